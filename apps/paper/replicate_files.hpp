#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/paper/replicate_items.hpp"
#include "apps/paper/replicate_output.hpp"
#include "apps/paper/replicate_page.hpp"
#include "apps/process/console.hpp"
#include "apps/process/output_folder.hpp"

namespace apps {

/// Replicates cases of Section 4 and writes their tables and figures into `folder`. What was found goes into `cases`,
/// what was written into `items`. Returns a summary, a line a case: how often every row was right, and how many printed
/// numbers agree.
[[nodiscard]] std::string write_section4(const std::vector<WantedCase>& wanted, const ReplicateOptions& options,
                                         const OutputFolder& folder, std::vector<ReplicatedCase>& cases,
                                         std::vector<ReplicatedItem>& items, Console& console);

/// Section 5 likewise; its rows go into `document`. A line a regime: T1 by the paper's recipe beside the print, and by
/// ours.
[[nodiscard]] std::string write_section5(const WantedOfRig& wanted, const Section5Options& options,
                                         const OutputFolder& folder, nlohmann::ordered_json& document,
                                         std::vector<ReplicatedItem>& items, Console& console);

}  // namespace apps
