#pragma once
#include <optional>
#include <string>
#include <vector>

#include "dsp/io/table_clock.hpp"

namespace dsp {

/// Whether a column is a clock: it rises throughout, by nearly the same step (half as much more or less, as loggers in
/// a busy computer do) nine times of ten, so that gaps do not matter, and not by ones, which count rows. What is
/// missing (NaN) is no clock's. At least eight values: fewer rise by chance.
[[nodiscard]] bool is_clock_like(const std::vector<double>& values);

/// The unit of such a column.
struct ClockUnit {
  std::string name;   ///< "s", "ms", "us"
  double in_s = 1.0;  ///< one of it
};
/// Where `rate_hz` is known, the unit that makes it the rate, nothing if none does. Else seconds, as vibration is
/// sampled faster than once a second; a column that would be slower than that in seconds could be in ms or in us, which
/// is a question: throws Fault clock.unit (input), whose lines() answer it with the one that makes 10 Hz or more, and
/// hold those for an uneven clock.
/// `stamps.time_s` are the values as they are, `column` counts from 1.
[[nodiscard]] std::optional<ClockUnit> unit_of_clock(const Stamps& stamps, int column, std::optional<double> rate_hz);

}  // namespace dsp
