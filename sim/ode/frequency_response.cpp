#include "sim/ode/frequency_response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <stdexcept>

#include "dsp/values/constants.hpp"

namespace sim {
namespace {

using dsp::nan;
using dsp::two_pi;

std::vector<ResponsePoint> sweep(const QzsParameters& parameters, std::vector<double> frequencies_hz,
                                 const FrequencyResponseOptions& options) {
  const Programme programme = sine_steps({.frequencies_hz = frequencies_hz,
                                          .amplitude_m = options.amplitude_m,
                                          .dwell_s = options.dwell_s,
                                          .transition_s = options.transition_s});
  const double duration_s = options.dwell_s * static_cast<double>(frequencies_hz.size());
  QzsTrajectory trajectory(std::make_shared<QzsRig>(parameters, programme), duration_s, options.poll);
  std::vector<ResponsePoint> points;
  for (std::size_t k = 0; k < frequencies_hz.size(); ++k) {
    // Whole periods, 200 samples each: a sine's peak is then met to 1.2e-4.
    const double f = frequencies_hz[k], end_s = options.dwell_s * static_cast<double>(k + 1);
    const double periods = std::max(1.0, std::floor(options.measured_fraction * options.dwell_s * f));
    const auto count = static_cast<int>(200.0 * periods);
    double x_low = std::numeric_limits<double>::infinity(), x_high = -x_low, y_low = x_low, y_high = -x_low;
    std::complex<double> x_turn, r_turn;  // fundamentals
    int stuck = 0;
    for (int i = 0; i < count; ++i) {
      const QzsState& state = trajectory.at(end_s - periods / f * (1.0 - static_cast<double>(i) / count));
      const double y = state.x + state.base.r_m;
      x_low = std::min(x_low, state.x), x_high = std::max(x_high, state.x);
      y_low = std::min(y_low, y), y_high = std::max(y_high, y);
      const auto turn = std::polar(1.0, -two_pi * periods * i / count);
      x_turn += state.x * turn, r_turn += state.base.r_m * turn;
      stuck += state.mode == qzs_stick;
    }
    points.push_back({.frequency_hz = f,
                      .x_m = 0.5 * (x_high - x_low),
                      .y_m = 0.5 * (y_high - y_low),
                      .phase_rad = stuck == count ? nan : std::arg(x_turn / r_turn),
                      .stuck_fraction = static_cast<double>(stuck) / count,
                      .locked = stuck == count});
  }
  return points;
}

}  // namespace

SweepChange change_between(const ResponsePoint& before, const ResponsePoint& here, double factor) {
  if (before.locked || here.locked)
    return before.locked == here.locked ? SweepChange::none : here.locked ? SweepChange::lock : SweepChange::unlock;
  if (here.x_m > factor * before.x_m) return SweepChange::jump_up;
  return before.x_m > factor * here.x_m ? SweepChange::jump_down : SweepChange::none;
}

ResponseJumps find_jumps(const std::vector<ResponsePoint>& up, const std::vector<ResponsePoint>& down, double factor) {
  const auto first = [factor](const std::vector<ResponsePoint>& points, SweepChange wanted) {
    for (std::size_t k = 1; k < points.size(); ++k)
      if (change_between(points[k - 1], points[k], factor) == wanted) return points[k].frequency_hz;
    return nan;
  };
  return {.unlock_rising_hz = first(up, SweepChange::unlock),
          .jump_up_rising_hz = first(up, SweepChange::jump_up),
          .jump_down_rising_hz = first(up, SweepChange::jump_down),
          .jump_up_falling_hz = first(down, SweepChange::jump_up),
          .jump_down_falling_hz = first(down, SweepChange::jump_down),
          .lock_falling_hz = first(down, SweepChange::lock)};
}

ResponsePoint peak(const std::vector<ResponsePoint>& points) {
  if (points.empty()) throw std::invalid_argument("peak: no points");
  return *std::max_element(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.x_m < b.x_m; });
}

std::vector<double> sweep_frequencies(const FrequencyResponseOptions& options) {
  const double count = std::round((options.to_hz - options.from_hz) / options.step_hz);
  if (!(options.step_hz > 0.0 && options.from_hz > 0.0 && count >= 1.0 && count <= 1e5))
    throw std::invalid_argument(fmt::format(
        "frequency_response: from_hz, to_hz and step_hz must make a sweep of 2 to 100000 positive frequencies, got "
        "{}, {} and {}",
        options.from_hz, options.to_hz, options.step_hz));
  std::vector<double> frequencies_hz;
  for (int k = 0; k <= static_cast<int>(count); ++k) frequencies_hz.push_back(options.from_hz + k * options.step_hz);
  return frequencies_hz;
}

FrequencyResponse frequency_response(const QzsParameters& parameters, const FrequencyResponseOptions& options) {
  std::vector<double> frequencies_hz = sweep_frequencies(options);
  FrequencyResponse response;
  response.up = sweep(parameters, frequencies_hz, options);
  std::reverse(frequencies_hz.begin(), frequencies_hz.end());
  response.down = sweep(parameters, frequencies_hz, options);
  response.jumps = find_jumps(response.up, response.down, options.jump_factor);
  return response;
}

}  // namespace sim
