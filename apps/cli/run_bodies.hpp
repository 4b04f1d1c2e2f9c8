#pragma once
#include "apps/cli/run_job.hpp"

// A recording of several bodies, or of one with an inner state: where run, check and predict do as for one.

namespace apps {

/// `error` is how a recording of several bodies is refused where one is wanted.
[[nodiscard]] bool is_of_bodies(const dsp::Fault& error);

/// One selection for all bodies, into a folder that is then finished. Throws dsp::Fault (usage, "bodies.config") for
/// settings that are for one body.
[[nodiscard]] RunOutcome run_bodies_into(RunFolder& results, const Config& config, const RunArguments& arguments,
                                         Console& console);

/// What a run would begin with, as lines or, for --json, as checks.
[[nodiscard]] std::string check_bodies(const Config& config, const RunArguments& arguments, Console& console);

}  // namespace apps
