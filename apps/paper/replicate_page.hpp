#pragma once
#include <string>
#include <vector>

#include "apps/paper/findings.hpp"

namespace apps {

/// A table or figure of the paper as it was written into the folder.
struct ReplicatedItem {
  std::string name, title;  ///< "table-1", "Table 1: duffing"
  std::string svg = {};     ///< of a figure; names inside begin with `name`
  std::string text = {};    ///< of a table, as its file has it
  JsonRows rows = {};       ///< of a table: every printed number beside ours
};

/// replicate.html: how the printed numbers fare, then table by table these beside ours with verdicts, and figures, in
/// the order of the items. As self-contained as report.html. `summary`: lines of text for its top.
[[nodiscard]] std::string replicate_page(const std::vector<ReplicatedItem>& items, const std::string& summary);

}  // namespace apps
