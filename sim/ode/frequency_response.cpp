#include "sim/ode/frequency_response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "dsp/values/constants.hpp"

namespace sim {

using dsp::nan;

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

}  // namespace sim
