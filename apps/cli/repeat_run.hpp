#pragma once
#include <filesystem>

#include "apps/cli/run_arguments.hpp"

namespace apps {

/// A folder with a manifest of Ardent's.
[[nodiscard]] bool is_finished_run(const std::filesystem::path& folder);

/// Does the run whose folder is arguments.input once more, from its config.toml, into a temporary folder or
/// arguments.folder, and prints whether inputs, program and results are the same. 0: all inputs and results are; 3: an
/// input has changed or is gone; 4: results differ though the inputs do not, or --require is not met. log.txt, which
/// has the times, and manifest.json do not count. Throws dsp::Fault, usage "run.repeat": results of another command, or
/// options that would change the run.
[[nodiscard]] int repeat_run(const RunArguments& arguments, Console& console);

}  // namespace apps
