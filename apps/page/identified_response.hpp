#pragma once
#include <optional>
#include <vector>

#include "apps/page/run_results.hpp"
#include "dsp/regimes/steady_steps.hpp"
#include "sim/ode/frequency_response.hpp"

namespace apps {

/// What the chosen equation makes of the steps of a stepped sine: walked up and down over their frequencies, driven by
/// the median of their amplitudes, friction at rest being what it is while sliding. Nothing for an equation that does
/// not describe its record or that a sine does not drive, for fewer than three steps of different frequencies, and for
/// a motion that runs away.
[[nodiscard]] std::optional<sim::FrequencyResponse> identified_response(const RunResults& results,
                                                                        const std::vector<dsp::SteadyStep>& steps);

}  // namespace apps
