#pragma once
#include <optional>
#include <string>
#include <vector>

#include "dsp/io/table_clock.hpp"

namespace dsp {

/// Whether a column that nobody called time is a clock: it rises throughout, by nearly the same step nine times of ten,
/// and not by ones, which count rows. What is missing (NaN) is no clock's. At least eight values.
[[nodiscard]] bool is_clock_like(const std::vector<double>& values);

/// The unit of such a column.
struct ClockUnit {
  std::string name;   ///< "s", "ms", "us"
  double in_s = 1.0;  ///< one of it
};
/// Where `rate_hz` is known, the unit that makes it the rate, nothing if none does. Else seconds, as vibration is
/// sampled faster than once a second; a column that would be slower than that in seconds could be in ms or in us, which
/// is a question: throws Fault clock.unit (input), whose lines() answer it with ms, with those for an uneven clock.
/// `stamps.time_s` are the values as they are, `column` counts from 1.
[[nodiscard]] std::optional<ClockUnit> unit_of_clock(const Stamps& stamps, int column, std::optional<double> rate_hz);

}  // namespace dsp
