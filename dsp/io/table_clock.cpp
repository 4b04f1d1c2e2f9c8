#include "dsp/io/table_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/io/recording_files.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/io/table_layout.hpp"
#include "dsp/values/order_statistics.hpp"

namespace dsp {
namespace {

constexpr double most_jitter_steps = 0.01;
// Straight lines between rows so far from their frames are off by 0.6 % of a sine with 8 samples a period.
constexpr double most_interpolated_steps = 0.1;

Fault fault(const Stamps& stamps, std::size_t row, std::string name, const std::string& what) {
  return Fault(FaultKind::input, std::move(name), fmt::format("{}:{}: {}", stamps.name, stamps.line(row), what));
}

Check note(CheckStatus status, std::string name, double value, double limit, std::string message) {
  return {std::move(name), "", status, value, limit, std::move(message)};
}

// Whether most rows come at no even pace at all, as where each is written when something has moved.
bool are_events(const Stamps& stamps) {
  constexpr double near = 0.25, most = 0.5;
  const std::vector<double> steps = steps_of(stamps.time_s);
  const double middle = median(steps);
  const auto uneven =
      std::count_if(steps.begin(), steps.end(), [&](double step) { return std::abs(step - middle) > near * middle; });
  return static_cast<double>(uneven) > most * static_cast<double>(steps.size());
}

// What has an uneven clock interpolated, for the top of the sidecar.
Fault interpolable(const Stamps& stamps, std::size_t row, std::string name, const std::string& what, double rate_hz) {
  constexpr double gap_steps = 3, event_rounder = 0.3;
  const double span_s = stamps.time_s.back() - stamps.time_s.front();
  const auto num_steps = static_cast<double>(stamps.time_s.size() - 1);
  const std::vector<double> steps = steps_of(stamps.time_s);
  const bool has_gaps = *std::max_element(steps.begin(), steps.end()) > gap_steps * median(steps);
  const bool events = are_events(stamps);
  if (events || !has_gaps) rate_hz = num_steps / span_s;
  const double rounder =
      std::clamp(1.0 / num_steps, 1e-3, 0.05);  // the first and the last stamp are off by up to a step
  return Fault(FaultKind::input, std::move(name),
               fmt::format("{}:{}: {}{}. To have it interpolated put at the top of {}:", stamps.name, stamps.line(row),
                           what, events ? "; its rows were written when something had moved, not at a rate" : "",
                           sidecar_path(stamps.name).string()),
               fmt::format("rate = {:.9g}\nclock = \"{}\"\n", roundest_rate(rate_hz, events ? event_rounder : rounder),
                           events ? "events" : "interpolate"));
}

// How far a stamp may lie from its true time: one digit where the rest was cut off, and the rounding of doubles.
double rounding_s(const Stamps& stamps) {
  const double largest = std::max(std::abs(stamps.time_s.front()), std::abs(stamps.time_s.back()));
  return stamps.printed_to_s + 4 * std::numeric_limits<double>::epsilon() * largest;
}

void check_increasing(const Stamps& stamps, bool repeats_allowed) {
  const auto& time_s = stamps.time_s;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    if (!std::isfinite(time_s[i])) throw fault(stamps, i, "clock.missing", "the time is missing");
    if (i == 0) continue;
    if (time_s[i] < time_s[i - 1])
      throw fault(stamps, i, "clock.backwards",
                  fmt::format("time goes back from {} to {} s", time_s[i - 1], time_s[i]));
    if (time_s[i] == time_s[i - 1] && !repeats_allowed)
      throw Fault(
          FaultKind::input, "clock.repeated",
          fmt::format("{}:{}: time {} s occurs twice. If it is printed too coarsely, state the rate at the top of "
                      "{}:",
                      stamps.name, stamps.line(i), time_s[i], sidecar_path(stamps.name).string()),
          fmt::format("{}\n", rate_line));
  }
}

// Largest deviation of the stamps from start + i / rate, taken about the middle of their spread.
double deviation_s(const std::vector<double>& time_s, std::size_t first, std::size_t last, double rate_hz) {
  double low = 0, high = 0;
  for (std::size_t i = first; i < last; ++i) {
    const double late_s = time_s[i] - time_s[first] - static_cast<double>(i - first) / rate_hz;
    low = std::min(low, late_s);
    high = std::max(high, late_s);
  }
  return 0.5 * (high - low);
}

bool explains_all(const Stamps& stamps, double rate_hz) {
  const auto& time_s = stamps.time_s;
  // Rounded or cut, stamps spread over one digit, and the deviation is half the spread.
  return deviation_s(time_s, 0, time_s.size(), rate_hz) <= 0.51 * rounding_s(stamps);
}

struct RowRange {
  std::size_t first, last;  // rows [first, last) without a gap
};

struct Steps {
  std::vector<RowRange> ranges;
  double mean_s = 0.0, uncertainty_s = 0.0;  // of a step within a range
  double least_s = 0.0, most_s = 0.0;
};

// Steps of more than 1.5 usual ones and `margin_s` are gaps.
Steps find_steps(const Stamps& stamps, double margin_s) {
  const auto& time_s = stamps.time_s;
  const std::size_t num_steps = time_s.size() - 1;
  const double gap_s = 1.5 * median(steps_of(time_s)) + margin_s;
  Steps found;
  found.least_s = std::numeric_limits<double>::infinity();
  std::size_t first = 0, count = 0;
  double sum_s = 0;
  for (std::size_t i = 0; i <= num_steps; ++i) {
    const double step_s = i < num_steps ? time_s[i + 1] - time_s[i] : std::numeric_limits<double>::infinity();
    if (step_s <= gap_s) {
      found.least_s = std::min(found.least_s, step_s);
      found.most_s = std::max(found.most_s, step_s);
      continue;
    }
    found.ranges.push_back({first, i + 1});
    sum_s += time_s[i] - time_s[first];
    count += i - first;
    first = i + 1;
  }
  found.mean_s = sum_s / static_cast<double>(count);
  found.uncertainty_s = rounding_s(stamps) * static_cast<double>(found.ranges.size()) / static_cast<double>(count);
  return found;
}

double deviation_s(const Stamps& stamps, const Steps& steps, double rate_hz) {
  double worst_s = 0;
  for (const auto& range : steps.ranges)
    worst_s = std::max(worst_s, deviation_s(stamps.time_s, range.first, range.last, rate_hz));
  return worst_s;
}

// What two stamps are printed to is no gap, unless nothing else explains steps of several usual ones: rows that got
// lost on a clock printed as coarsely as its step.
Steps find_steps(const Stamps& stamps) {
  const Steps steps = find_steps(stamps, 2 * stamps.printed_to_s);
  const auto is_even = [&](const Steps& found) {
    const double off_s = rounding_s(stamps) + most_jitter_steps * found.mean_s;
    // Printed to one digit, the steps of an even clock differ by one at most.
    return deviation_s(stamps, found, 1 / found.mean_s) <= off_s && found.most_s - found.least_s <= 1.01 * off_s;
  };
  if (is_even(steps)) return steps;
  Steps with_losses = find_steps(stamps, 4 * std::numeric_limits<double>::epsilon() * stamps.time_s.back());
  return is_even(with_losses) ? with_losses : steps;
}

// The roundest rate that the stamps allow. Where they tremble, the first and last, of which the rate was measured, do
// too: a round rate that leaves them no further off than the measured one is the recorder's.
double roundest_allowed(const Stamps& stamps, const Steps& steps, double measured_hz, double uncertainty,
                        double jitter) {
  const double rate_hz = roundest_rate(measured_hz, uncertainty + jitter);
  constexpr double no_further = 1.1;
  const double most_s = no_further * deviation_s(stamps, steps, measured_hz) + rounding_s(stamps);
  return deviation_s(stamps, steps, rate_hz) <= most_s ? rate_hz : roundest_rate(measured_hz, uncertainty);
}

double choose_rate(const Stamps& stamps, const ClockOptions& options, const Steps& steps, Clock& clock) {
  const double measured_hz = 1 / steps.mean_s, uncertainty = std::max(steps.uncertainty_s / steps.mean_s, 1e-9);
  const double span_s = steps.mean_s * static_cast<double>(stamps.time_s.size() - steps.ranges.size());
  const double off_s = deviation_s(stamps, steps, measured_hz);
  const double most_s = (off_s > most_interpolated_steps * steps.mean_s ? most_jitter_steps : 1.0) * steps.mean_s;
  const double jitter_s = off_s > rounding_s(stamps) ? std::min(2 * off_s, most_s) : 0.0;
  const double jitter = jitter_s * static_cast<double>(steps.ranges.size()) / span_s;
  if (options.rate_hz) {
    const double tolerance = std::max({0.5 * uncertainty, jitter, 1e-6});
    if (std::abs(*options.rate_hz / measured_hz - 1) > tolerance)
      throw Fault(FaultKind::input, "rate.mismatch",
                  fmt::format("{}: the sidecar says {} Hz, the time column {:.9g} Hz. Correct the one that is wrong",
                              stamps.name, *options.rate_hz, measured_hz));
    return *options.rate_hz;
  }
  const double rate_hz = roundest_allowed(stamps, steps, measured_hz, uncertainty, jitter);
  if (options.header_rate_hz)
    clock.checks.push_back(
        note(CheckStatus::warning, "clock.header", *options.header_rate_hz, rate_hz,
             fmt::format("{}: the header says {} Hz, the time column {} Hz; the time column was taken", stamps.name,
                         *options.header_rate_hz, rate_hz)));
  const double uneven_s = steps.most_s - steps.least_s;
  constexpr double least_worth_telling = 1e-6;  // of a step
  if (stamps.printed_to_s > least_worth_telling * steps.mean_s && uneven_s > 0.5 * stamps.printed_to_s)
    clock.checks.push_back(
        note(CheckStatus::note, "clock.printed", rate_hz, 0.0,
             fmt::format("{}: time is printed to {:g} s, so steps of {:.9g} to {:.9g} s were read as {} Hz",
                         stamps.name, stamps.printed_to_s, steps.least_s, steps.most_s, rate_hz)));
  return rate_hz;
}

// How far stamps are off the frames, in steps, beyond what they are printed to; throws clock.jitter where that is more
// than straight lines may make good.
double check_jitter(const Stamps& stamps, const Steps& steps, Clock& clock) {
  double worst_s = 0;
  std::size_t where = 0;
  for (const auto& range : steps.ranges) {
    const double late_s = deviation_s(stamps.time_s, range.first, range.last, clock.rate_hz);
    if (late_s > worst_s) where = range.first;
    worst_s = std::max(worst_s, late_s);
  }
  constexpr double least_worth_telling = 1e-4;
  const double jitter_steps = worst_s * clock.rate_hz;
  if (worst_s <= rounding_s(stamps) || jitter_steps < least_worth_telling) return 0.0;
  if (jitter_steps > most_interpolated_steps)
    throw interpolable(
        stamps, where, "clock.jitter",
        fmt::format(
            "the time column is uneven: off an even {:.9g} Hz by up to {:.3g} steps (steps of {:.6g} to {:.6g} s)",
            clock.rate_hz, jitter_steps, steps.least_s, steps.most_s),
        clock.rate_hz);
  clock.checks.push_back(note(
      CheckStatus::warning, "clock.jitter", jitter_steps, most_interpolated_steps,
      fmt::format("{}: the time column is off an even {} Hz by up to {:.2g} of a step{}", stamps.name, clock.rate_hz,
                  jitter_steps, jitter_steps > most_jitter_steps ? "; rows were interpolated by straight lines" : "")));
  return jitter_steps;
}

void add_gap(const Stamps& stamps, std::size_t row, Clock& clock) {
  clock.gaps.push_back(
      {stamps.time_s[row - 1] - clock.start_s, stamps.time_s[row] - clock.start_s, "gap in the clock", true});
  clock.first_gap_row = clock.gaps.size() == 1 ? row : clock.first_gap_row;
}

// One line for all gaps.
void note_gaps(const Stamps& stamps, Clock& clock) {
  if (clock.gaps.empty()) return;
  double longest_s = 0.0, sum_s = 0.0;
  for (const Interval& gap : clock.gaps) {
    longest_s = std::max(longest_s, gap.to_s - gap.from_s);
    sum_s += gap.to_s - gap.from_s;
  }
  const std::string others = clock.gaps.size() == 1 ? ""
                                                    : fmt::format(
                                                          ", the first of {} gaps, {:.4g} s in all, at "
                                                          "most {:.4g} s",
                                                          clock.gaps.size(), sum_s, longest_s);
  clock.checks.push_back(
      note(CheckStatus::warning, "clock.gap", longest_s, 1 / clock.rate_hz,
           fmt::format("{}:{}: the clock skips {:.4g} s{}", stamps.name, stamps.line(clock.first_gap_row),
                       clock.gaps.front().to_s - clock.gaps.front().from_s, others)));
}

// Whole steps across the gaps; the rows behind one move by as many frames as are missing. Rows are where their stamps
// are if these are `uneven`, else on the frames.
void place_rows(const Stamps& stamps, const Steps& steps, bool uneven, Clock& clock) {
  clock.num_frames = static_cast<std::int64_t>(stamps.time_s.size());
  if (steps.ranges.size() == 1 && !uneven) return;
  clock.position.reserve(stamps.time_s.size());
  double missing = 0;
  for (const auto& range : steps.ranges) {
    if (range.first > 0) {
      const double gap_s = stamps.time_s[range.first] - stamps.time_s[range.first - 1];
      const double frames = std::round(gap_s * clock.rate_hz);
      const double off_s = std::abs(gap_s - frames / clock.rate_hz);
      const double most_steps = uneven ? 2 * most_interpolated_steps : most_jitter_steps;
      if (off_s > most_steps / clock.rate_hz + 2 * rounding_s(stamps))
        throw interpolable(stamps, range.first, "clock.gap",
                           fmt::format("the clock skips {:.6g} s, which is no whole number of steps of {:.6g} s", gap_s,
                                       1 / clock.rate_hz),
                           clock.rate_hz);
      missing += frames - 1;
      add_gap(stamps, range.first, clock);
    }
    for (std::size_t i = range.first; i < range.last; ++i)
      clock.position.push_back(uneven ? (stamps.time_s[i] - stamps.time_s[0]) * clock.rate_hz
                                      : static_cast<double>(i) + missing);
  }
  if (missing > static_cast<double>(stamps.time_s.size()))
    throw fault(stamps, 0, "clock.gap",
                fmt::format("more is missing ({} frames) than is there ({})", missing, stamps.time_s.size()));
  clock.num_frames += static_cast<std::int64_t>(missing);
  // The last frame is not to lie behind the last row.
  if (uneven) clock.position.back() = std::max(clock.position.back(), static_cast<double>(clock.num_frames - 1));
  note_gaps(stamps, clock);
}

Clock interpolated_clock(const Stamps& stamps, double rate_hz, ClockKind kind) {
  const auto& time_s = stamps.time_s;
  constexpr double most_frames_per_row = 100, gap_steps = 3;
  const double span_s = time_s.back() - time_s.front(), rows = static_cast<double>(time_s.size());
  if (span_s * rate_hz > most_frames_per_row * rows)
    throw fault(stamps, 0, "clock.gap",
                fmt::format("{} rows over {:.6g} s are too few for {} Hz", time_s.size(), span_s, rate_hz));
  Clock clock;
  clock.rate_hz = rate_hz;
  clock.start_s = time_s.front();
  clock.num_frames = static_cast<std::int64_t>(std::floor(span_s * rate_hz * (1 + 1e-12))) + 1;
  const double usual_s = median(steps_of(time_s));
  clock.position.reserve(time_s.size());
  for (const double at_s : time_s) clock.position.push_back((at_s - time_s.front()) * rate_hz);
  // Rounding must not put the last frame behind the last row.
  clock.position.back() = std::max(clock.position.back(), static_cast<double>(clock.num_frames - 1));
  for (std::size_t i = 1; i < time_s.size() && kind == ClockKind::interpolate; ++i)
    if (time_s[i] - time_s[i - 1] > gap_steps * usual_s) add_gap(stamps, i, clock);
  note_gaps(stamps, clock);
  clock.checks.push_back(note(CheckStatus::warning, "clock.interpolated", rows, static_cast<double>(clock.num_frames),
                              fmt::format("{}: {} uneven rows were interpolated onto {} Hz as the sidecar asks",
                                          stamps.name, time_s.size(), rate_hz)));
  return clock;
}

}  // namespace

std::vector<double> steps_of(const std::vector<double>& stamps) {
  std::vector<double> steps(stamps.empty() ? 0 : stamps.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = stamps[i + 1] - stamps[i];
  return steps;
}

std::int64_t Stamps::line(std::size_t row) const {
  const auto at = static_cast<std::int64_t>(row);
  const auto skipped = std::upper_bound(skipped_before.begin(), skipped_before.end(), at) - skipped_before.begin();
  return first_line + at + skipped;
}

Clock even_clock(const Stamps& stamps, const ClockOptions& options) {
  check_increasing(stamps, options.rate_hz && options.kind == ClockKind::regular);
  Clock clock;
  clock.start_s = stamps.time_s.front();
  clock.num_frames = static_cast<std::int64_t>(stamps.time_s.size());
  if (stamps.time_s.size() == 1) {
    clock.rate_hz = options.rate_hz.value_or(options.header_rate_hz.value_or(0));
    return clock;
  }
  if (options.kind != ClockKind::regular && options.rate_hz)
    return interpolated_clock(stamps, *options.rate_hz, options.kind);
  for (const auto& stated_hz : {options.rate_hz, options.header_rate_hz})
    if (stated_hz && explains_all(stamps, *stated_hz)) {
      clock.rate_hz = *stated_hz;
      return clock;
    }
  check_increasing(stamps, false);
  const Steps steps = find_steps(stamps);
  clock.rate_hz = choose_rate(stamps, options, steps, clock);
  place_rows(stamps, steps, check_jitter(stamps, steps, clock) > most_jitter_steps, clock);
  return clock;
}

}  // namespace dsp
