#pragma once
#include <filesystem>

#include "apps/process/console.hpp"

namespace apps {

/// `ardent report`: the page of a finished run again (with --json its equation.json). Throws dsp::Fault (input,
/// "run.incomplete") for a folder that holds no finished run with fits.
void run_report(const std::filesystem::path& run, Console& console);

}  // namespace apps
