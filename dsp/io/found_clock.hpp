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

/// Whether a column of so many seconds rises as a stated rate has it.
[[nodiscard]] bool is_on_rate(const std::vector<double>& time_s, double rate_hz);

/// The unit of such a column.
struct ClockUnit {
  std::string name;   ///< "s", "ms", "us", "ns"
  double in_s = 1.0;  ///< one of it
};
/// That in which stamps count from 1970, by their size; nothing where they do in none.
[[nodiscard]] std::optional<ClockUnit> unit_of_epoch(const Stamps& stamps);

/// Where `rate_hz` is known, the unit that makes it the rate, nothing if none does. Else that of an epoch, else
/// seconds, as vibration is sampled faster than once a second; a column that would be slower than that in seconds could
/// be in ms or less, which is a question: throws Fault clock.unit (input), whose lines() answer it with the first that
/// makes 10 Hz or more, and hold those for an uneven clock. `stamps.time_s` are the values as they are, `column` counts
/// from 1.
[[nodiscard]] std::optional<ClockUnit> unit_of_clock(const Stamps& stamps, int column, std::optional<double> rate_hz);

/// A counter of `unit_s` that began anew at 2^16 or 2^32, as microcontrollers' do, goes on instead, with a note: where
/// a stamp goes back by so much less a usual step.
void unwrap_counter(Stamps& stamps, double unit_s, std::vector<Check>& checks);

/// Puts the stamps of a column whose unit is not known in seconds: one that is called time is in seconds unless that
/// would be slower than any vibration is sampled or another unit makes the stated rate. Throws as unit_of_clock, and
/// Fault rate.mismatch (input) where a column of another name rises evenly and at another rate.
void settle_unit(Stamps& stamps, int column, bool is_named, std::optional<double> rate_hz, std::vector<Check>& checks);

}  // namespace dsp
