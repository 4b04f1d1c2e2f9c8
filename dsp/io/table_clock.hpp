#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dsp/io/clock_kind.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

/// The time column of a table.
struct Stamps {
  std::vector<double> time_s;
  double printed_to_s = 0.0;                   ///< the last digit printed
  std::int64_t first_line = 1;                 ///< of the first row, for messages
  std::string name;                            ///< of the file
  std::vector<std::int64_t> skipped_before{};  ///< for each line that is no row, the row behind it; ascending
  [[nodiscard]] std::int64_t line(std::size_t row) const;
};

/// From each stamp to the next, in the unit of the stamps.
[[nodiscard]] std::vector<double> steps_of(const std::vector<double>& stamps);

struct ClockOptions {
  std::optional<double> rate_hz{};         ///< what a person says
  std::optional<double> header_rate_hz{};  ///< what the file says elsewhere; given up where the stamps contradict it
  ClockKind kind = ClockKind::regular;     ///< else any increasing stamps, and an even grid of rate_hz over them
};

/// An even grid of frames and where the rows lie on it.
struct Clock {
  double rate_hz = 0.0, start_s = 0.0;
  std::int64_t num_frames = 0;
  std::vector<double> position;   ///< of each row, in frames; empty: row i is frame i
  std::vector<Interval> gaps;     ///< seconds from the start
  std::size_t first_gap_row = 0;  ///< the row behind the first of them
  std::vector<Check> checks;
};

/// Most memory that even_clock holds at a time, its stamps included: beside them their steps or the rows' positions.
constexpr double clock_bytes_per_row = 2 * sizeof(double);

/// Even to within 1 % of a step and the printed digits: the rate is the roundest that explains all stamps; steps of
/// several frames are gaps. Up to 10 % of a step rows are interpolated by straight lines, with a warning. Throws Fault
/// (input): clock.backwards, clock.repeated, clock.jitter, clock.gap, rate.mismatch, with the line and the remedy.
[[nodiscard]] Clock even_clock(const Stamps& stamps, const ClockOptions& options);

}  // namespace dsp
