#pragma once
#include <filesystem>
#include <optional>

#include "apps/cli/run_arguments.hpp"

namespace apps {

/// A folder with a manifest of Ardent's.
[[nodiscard]] bool is_finished_run(const std::filesystem::path& folder);

/// The exit code of the run in `folder` if it is the very one that `origin` asks for with this config: inputs, settings
/// and program are the same by their SHA-256, and so are the files it wrote. Throws dsp::Fault (input) for a recording
/// that cannot be read.
[[nodiscard]] std::optional<int> kept_exit_code(const std::filesystem::path& folder, const Config& config,
                                                const RunFolder::Origin& origin);

/// Does the run whose folder is arguments.input once more, from its config.toml, into a temporary folder or
/// arguments.folder, and prints whether inputs, program and results are the same. 0: all inputs and results are; 3: an
/// input has changed or is gone; 4: results differ though the inputs do not, or --require is not met. log.txt, which
/// has the times, and manifest.json do not count. Throws dsp::Fault, usage "run.repeat": results of another command, or
/// options that would change the run.
[[nodiscard]] int repeat_run(const RunArguments& arguments, Console& console);

}  // namespace apps
