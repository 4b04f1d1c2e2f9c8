#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/process/console.hpp"

namespace apps {

/// `ardent replicate ITEM... -o DIR ...` as it was typed; what is left out has the default named here.
struct ReplicateArguments {
  std::vector<std::string> items;  ///< a case (duffing ... valanis-4, qzs-low ... qzs-mixed), qzs for all that is of
                                   ///< the rig, table-1 ... table-12, fig-2 ... fig-9, fig-11 ... fig-13, all
  std::filesystem::path folder;    ///< of the results
  bool force = false;              ///< replace an existing folder of results
  int num_seeds = 1;
  std::uint64_t first_seed = 1;
  std::optional<double> noise;  ///< fraction of each target's standard deviation over the training set (0.1);
                                ///< the rig: times the sensors' own (1)
  std::string selection = "evidence-white";  ///< or "evidence", or "type2", the paper's own
  std::optional<double> tau;                 ///< ln m + 2 ln b (evidence), 0 (type2)
  std::vector<std::string> command_line{};
};

/// Sections 4 and 5 of [QZS23] again: writes replicate.json, table-N.txt and fig-N.svg. Throws dsp::Fault: usage for
/// unknown items and values that make no sense, output where the folder cannot be written.
void run_replicate(const ReplicateArguments& arguments, Console& console);

}  // namespace apps
