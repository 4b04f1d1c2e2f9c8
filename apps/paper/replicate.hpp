#pragma once
#include <string>
#include <vector>

#include "apps/output/output_folder.hpp"
#include "apps/paper/replicate_case.hpp"
#include "apps/process/console.hpp"

namespace apps {

/// Throws dsp::Fault (usage, "replicate.item") for a name that is no case (duffing ... valanis-4, qzs-low ...
/// qzs-mixed), qzs for all that is of the rig, table-1 ... table-12, fig-2 ... fig-9, fig-11 ... fig-13, or all; and
/// for none.
void require_items(const std::vector<std::string>& items);

/// Replicates what is asked for and writes table-N.txt, fig-N.svg, replicate.json and replicate.html into `folder`.
struct Replicated {
  std::string json;     ///< replicate.json
  std::string summary;  ///< a line a case: how often every row was right, and how many printed numbers agree
};
[[nodiscard]] Replicated replicate(const std::vector<std::string>& items, const ReplicateOptions& options,
                                   const ReplicateOptions& rig_options, const OutputFolder& folder, Console& console);

}  // namespace apps
