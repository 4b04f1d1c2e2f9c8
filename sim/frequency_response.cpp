#include "sim/frequency_response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace sim {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<ResponsePoint> sweep(const QzsParameters& parameters, std::vector<double> frequencies_hz,
                                 const FrequencyResponseOptions& options) {
  const Programme programme = sine_steps({.frequencies_hz = frequencies_hz,
                                          .amplitude_m = options.amplitude_m,
                                          .dwell_s = options.dwell_s,
                                          .transition_s = options.transition_s});
  const double duration_s = options.dwell_s * static_cast<double>(frequencies_hz.size());
  QzsTrajectory trajectory(std::make_shared<QzsRig>(parameters, programme), duration_s);
  std::vector<ResponsePoint> points;
  for (std::size_t k = 0; k < frequencies_hz.size(); ++k) {
    // Whole periods, 200 samples each: a sine's peak is then met to 1.2e-4.
    const double f = frequencies_hz[k], end_s = options.dwell_s * static_cast<double>(k + 1);
    const double periods = std::max(1.0, std::floor(options.measured_share * options.dwell_s * f));
    const auto count = static_cast<int>(200.0 * periods);
    double x_low = std::numeric_limits<double>::infinity(), x_high = -x_low, y_low = x_low, y_high = -x_low;
    int stuck = 0;
    for (int i = 0; i < count; ++i) {
      const QzsState& state = trajectory.at(end_s - periods / f * (1.0 - static_cast<double>(i) / count));
      const double y = state.x + state.base.r_m;
      x_low = std::min(x_low, state.x), x_high = std::max(x_high, state.x);
      y_low = std::min(y_low, y), y_high = std::max(y_high, y);
      stuck += state.mode == qzs_stick;
    }
    points.push_back(
        {f, 0.5 * (x_high - x_low), 0.5 * (y_high - y_low), static_cast<double>(stuck) / count, stuck == count});
  }
  return points;
}

}  // namespace

FrequencyResponse frequency_response(const QzsParameters& parameters, const FrequencyResponseOptions& options) {
  if (!(options.step_hz > 0.0 && options.from_hz > 0.0 && options.to_hz > options.from_hz))
    throw std::invalid_argument(
        "frequency_response: from_hz, to_hz and step_hz must make a sweep of positive frequencies");
  std::vector<double> frequencies_hz;
  const auto count = static_cast<int>(std::lround((options.to_hz - options.from_hz) / options.step_hz));
  for (int k = 0; k <= count; ++k) frequencies_hz.push_back(options.from_hz + k * options.step_hz);
  FrequencyResponse response;
  response.up = sweep(parameters, frequencies_hz, options);
  std::reverse(frequencies_hz.begin(), frequencies_hz.end());
  response.down = sweep(parameters, frequencies_hz, options);

  response.unlock_up_hz = response.fall_up_hz = response.jump_down_hz = response.lock_down_hz = nan;
  const auto first = [](double& found, double frequency_hz) {
    if (std::isnan(found)) found = frequency_hz;
  };
  for (std::size_t k = 1; k < response.up.size(); ++k) {
    const ResponsePoint &before = response.up[k - 1], &here = response.up[k];
    if (before.locked && !here.locked) first(response.unlock_up_hz, here.frequency_hz);
    if (!before.locked && here.x_m * options.jump_factor < before.x_m) first(response.fall_up_hz, here.frequency_hz);
  }
  for (std::size_t k = 1; k < response.down.size(); ++k) {
    const ResponsePoint &before = response.down[k - 1], &here = response.down[k];
    if (!before.locked && here.x_m > options.jump_factor * before.x_m) first(response.jump_down_hz, here.frequency_hz);
    if (!before.locked && here.locked) first(response.lock_down_hz, here.frequency_hz);
  }
  return response;
}

}  // namespace sim
