#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "apps/cli/run_arguments.hpp"

namespace apps {

/// What `ardent run` leaves beside its folder.
struct RunOutcome {
  Config config;                             ///< with everything settled
  std::vector<std::filesystem::path> files;  ///< that were read
  std::string report, equation;              ///< equation.txt: the first screen; equation.json
  int exit_code = 0;                         ///< 4 where a range has no fit to show, or --require is not met
};

/// From recordings to judged equations, into a folder that is then finished.
[[nodiscard]] RunOutcome run_into(RunFolder& results, const Config& config, const RunArguments& arguments,
                                  Console& console);

}  // namespace apps
