#pragma once
#include <filesystem>

#include "apps/process/console.hpp"

namespace apps {

/// A folder that a run finished. Each file in it that is missing or has changed since is named by a warning
/// ("run.changed"), where `strict` refused. Throws dsp::Fault (input): "run.incomplete" without a manifest.json, which
/// is written last; "run.damaged", "strict.warning".
void check_finished_run(const std::filesystem::path& run, bool strict, Console& console);

}  // namespace apps
