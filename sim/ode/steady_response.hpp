#pragma once
#include <functional>

#include "sim/ode/driven_oscillator.hpp"
#include "sim/ode/frequency_response.hpp"

namespace sim {

struct SteadyOptions {
  int num_natural_periods = 6;  ///< integrated before the periodic motion is looked for: the way is found by dynamics
  int max_periods = 3000;       ///< of one frequency, after which it counts as unsettled
  double tolerance = 1e-8;      ///< change of state over a period, as a fraction of the amplitude
  double nearness = 0.1;        ///< a periodic motion further off than this fraction of the amplitude is another one,
                                ///< unless the way to it is straight
  double locate_hz = 1e-5;      ///< jumps are located to this, and what is steep but no jump is left out; 0: neither
  std::function<void()> poll = {};  ///< called for every period computed; may throw to stop
};

/// The frequency response of what is driven, where its steady motion is periodic.
struct SteadyResponse {
  FrequencyResponse response;
  ResponseJumps located;     ///< the jumps of `response` between two of its frequencies, to locate_hz
  int num_unsettled = 0;     ///< frequencies without a periodic motion: subharmonic, chaotic or out of patience
  double diverged_hz = 0.0;  ///< where the motion ran away, and the sweep ended; NaN: nowhere
};

/// The frequencies walked up and down from rest; at each the motion is integrated from where the last left it, and
/// brought to the stable periodic motion nearby by Newton's method on the state one period later (shooting).
/// `options`: its dwell, transition and measured fraction play no part; its amplitude is that of the drive.
/// Throws std::invalid_argument as sweep_frequencies.
[[nodiscard]] SteadyResponse steady_response(const DrivenSystem& driven, const FrequencyResponseOptions& options,
                                             const SteadyOptions& steady = {});
[[nodiscard]] inline SteadyResponse steady_response(const DrivenOscillator& oscillator,
                                                    const FrequencyResponseOptions& options,
                                                    const SteadyOptions& steady = {}) {
  return steady_response(driven_system(oscillator), options, steady);
}

}  // namespace sim
