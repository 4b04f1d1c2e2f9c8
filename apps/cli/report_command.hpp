#pragma once
#include <filesystem>

#include "apps/process/console.hpp"

namespace apps {

/// `ardent report`: the page of a finished run again (with --json its equation.json). Throws dsp::Fault (input) as
/// check_finished_run, "run.incomplete" also for a run without fits.
void run_report(const std::filesystem::path& run, bool strict, Console& console);

}  // namespace apps
