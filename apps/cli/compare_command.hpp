#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "apps/process/console.hpp"

namespace apps {

struct CompareArguments {
  std::vector<std::filesystem::path> runs;  ///< run folders, one column each
  std::filesystem::path truth;              ///< truth.json of a simulation, or empty
  std::string method = "fast_rvm";          ///< the first method of a run that does not have it
  bool strict = false;
};

/// `ardent compare`: the equations of several runs side by side, range by range, with coefficients of variation and
/// NMSE. Throws dsp::Fault (input) as check_finished_run.
void run_compare(const CompareArguments& arguments, Console& console);

}  // namespace apps
