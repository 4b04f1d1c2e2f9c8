#pragma once
#include <string>
#include <vector>

#include "apps/paper/replicate_case.hpp"
#include "apps/paper/rig.hpp"

namespace apps {

/// Heads, each with "<" or ">" before it for how its column is aligned, and rows of cells.
struct PaperTable {
  std::string caption;
  std::vector<std::string> heads;
  std::vector<std::vector<std::string>> rows;
  [[nodiscard]] std::string text() const;
};

/// Printed numbers beside ours (rows of "paper"), a table for each quantity.
[[nodiscard]] std::vector<PaperTable> compared_tables(const JsonRows& rows);

/// What stands beside these in the file of a case of Section 4: how often its terms are found, how well error bars and
/// bands of the fast RVM hold over all seeds, errors of free runs, times.
[[nodiscard]] std::string case_text(const CaseReplication& replication, const ReplicateOptions& options);

/// What stands in those of Table 9, errors by regime, method and way with free runs, and of Tables 10-12, coefficients
/// in SI beside the truth; with what differs and why. `rows` of "paper" are the table's.
[[nodiscard]] std::string rig_errors_text(const RigReplication& replication, const std::vector<RigRegime>& regimes,
                                          const JsonRows& rows);
[[nodiscard]] std::string rig_text(const RigReplication& replication, const RigRegime& regime, const JsonRows& rows);

}  // namespace apps
