#include "dsp/io/found_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "dsp/io/sidecar.hpp"
#include "dsp/io/table_layout.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/order_statistics.hpp"

namespace dsp {
namespace {

const std::array<ClockUnit, 4> clock_units{{{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}}};
const ClockUnit in_days{"d", day_s};  // of spreadsheets and of MATLAB
// A step that no recorder of vibration has in seconds: 2 MHz. A part of a day it may be.
constexpr double shortest_step_s = 5e-7;

// The steps between stamps are even within their last digit, if not always, then in the middle.
double rate_hz_of(double step, const Stamps& stamps, const ClockUnit& unit) {
  return roundest_rate(1.0 / (step * unit.in_s), std::min(0.5 * stamps.printed_to_s / step, 1e-3));
}

Stamps in_unit(Stamps stamps, const ClockUnit& unit) {
  for (double& time_s : stamps.time_s) time_s *= unit.in_s;
  stamps.printed_to_s *= unit.in_s;
  return stamps;
}

// Nothing where the clock is even enough as it is.
std::string interpolation_lines(const Stamps& stamps, double rate_hz) {
  try {
    (void)even_clock(stamps, {});
    return "";
  } catch (const Fault&) {
    return fmt::format("rate = {:.6g}\nclock = \"interpolate\"  # its steps are uneven\n", rate_hz);
  }
}

Fault ask_for_days(const Stamps& stamps, int column, double step) {
  return Fault(
      FaultKind::input, "clock.unit",
      fmt::format("{}: column {} rises by {:.6g} from row to row and seems to be the time. In seconds that "
                  "would be {:.4g} Hz, in days {:.6g} Hz. Say which it is in {}, its first lines:",
                  stamps.name, column, step, 1.0 / step, rate_hz_of(step, stamps, in_days),
                  sidecar_path(stamps.name).string()),
      fmt::format("[[channel]]\nname = \"t\"\nindex = {}\nrole = \"t\"\nunit = \"d\"  # days; or \"s\"\n", column));
}

}  // namespace

bool is_clock_like(const std::vector<double>& values) {
  constexpr std::size_t fewest = 8;
  constexpr double usual = 0.9, nearly = 0.5;
  if (values.size() < fewest) return false;
  bool by_ones = true;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = values[i] - values[i - 1];
    if (!(step > 0.0) || !std::isfinite(step)) return false;
    by_ones = by_ones && step == 1.0;
  }
  if (by_ones) return false;
  const double middle = median(steps_of(values));
  std::size_t num_even = 0;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (std::abs(values[i] - values[i - 1] - middle) <= nearly * middle) ++num_even;
  return static_cast<double>(num_even) >= usual * static_cast<double>(values.size() - 1);
}

// Days since 1900 (spreadsheets), since the year 0 (MATLAB) or of the Julian count, 1980 to 2100: stamps so large that
// rise by so little.
bool are_days(const Stamps& stamps, double step) {
  struct Range {
    double from, to;
  };
  constexpr std::array epochs{Range{29'221, 73'051}, Range{723'181, 767'011}, Range{2'444'239, 2'488'070}};
  return step > 0.0 && step < 1.0 / day_s && std::any_of(epochs.begin(), epochs.end(), [&](const Range& one) {
           return stamps.time_s.front() > one.from && stamps.time_s.back() < one.to;
         });
}

bool is_on_rate(const std::vector<double>& time_s, double rate_hz) {
  constexpr double agreeing = 1e-3;  // a ramp of another slope is a signal
  return std::abs(median(steps_of(time_s)) * rate_hz - 1.0) < agreeing;
}

void unwrap_counter(Stamps& stamps, double unit_s, std::vector<Check>& checks) {
  auto& time_s = stamps.time_s;
  if (time_s.size() < 2 || std::is_sorted(time_s.begin(), time_s.end())) return;
  const double step_s = median(steps_of(time_s));
  constexpr double near = 0.5;  // of a step
  int num_wraps = 0;
  double ahead_s = 0.0, before_s = time_s.front();
  std::vector<double> unwrapped = time_s;
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    for (const int bits : {16, 32}) {
      const double period_s = std::ldexp(unit_s, bits);
      const double off_s = time_s[i] + period_s - before_s - step_s;
      if (time_s[i] >= before_s || before_s >= period_s || std::abs(off_s) > near * step_s) continue;
      ahead_s += period_s;
      ++num_wraps;
    }
    before_s = time_s[i];
    unwrapped[i] += ahead_s;
  }
  if (num_wraps == 0 || !std::is_sorted(unwrapped.begin(), unwrapped.end())) return;
  time_s = std::move(unwrapped);
  checks.push_back({"clock.wrapped", "", CheckStatus::note, static_cast<double>(num_wraps), 0.0,
                    fmt::format("{}: the counter that is the clock began anew {}; it was taken to go on", stamps.name,
                                num_wraps == 1 ? "once" : fmt::format("{} times", num_wraps))});
}

std::optional<ClockUnit> unit_of_epoch(const Stamps& stamps) {
  constexpr double from_s = 3.2e8, to_s = 4e9;  // 1980 to 2096
  constexpr double slowest_step_s = 10.0;       // or it counts something else
  const double step = median(steps_of(stamps.time_s));
  for (const ClockUnit& unit : clock_units)
    if (stamps.time_s.front() * unit.in_s > from_s && stamps.time_s.back() * unit.in_s < to_s && step > 0.0 &&
        step * unit.in_s < slowest_step_s)
      return unit;
  return are_days(stamps, step) ? std::optional(in_days) : std::nullopt;
}

std::optional<ClockUnit> unit_of_clock(const Stamps& stamps, int column, std::optional<double> rate_hz) {
  constexpr double agreeing = 0.02;  // the middle step of a coarse clock is not its mean
  const double step = median(steps_of(stamps.time_s));
  if (rate_hz) {
    const auto found = std::find_if(clock_units.begin(), clock_units.end(), [&](const ClockUnit& unit) {
      return std::abs(step * unit.in_s * *rate_hz - 1.0) < agreeing;
    });
    if (found == clock_units.end())
      return std::abs(step * in_days.in_s * *rate_hz - 1.0) < agreeing ? std::optional(in_days) : std::nullopt;
    return *found;
  }
  if (const auto epoch = unit_of_epoch(stamps)) return epoch;
  if (step > 0.0 && step < shortest_step_s) throw ask_for_days(stamps, column, step);
  if (step < 1.0) return clock_units[0];
  constexpr double slowest_hz = 10.0;  // of a recorder of vibration
  std::size_t likely = 1;
  while (likely + 1 < clock_units.size() && rate_hz_of(step, stamps, clock_units[likely]) < slowest_hz) ++likely;
  std::string rates;
  for (std::size_t i = 1; i < clock_units.size(); ++i)
    rates += fmt::format(", in {} {:.6g} Hz", clock_units[i].name, rate_hz_of(step, stamps, clock_units[i]));
  throw Fault(
      FaultKind::input, "clock.unit",
      fmt::format("{}: column {} rises by {:.6g} from row to row and seems to be the time. In seconds that would "
                  "be {:.3g} Hz{}. Say which it is in {}, its first lines:",
                  stamps.name, column, step, 1.0 / step, rates, sidecar_path(stamps.name).string()),
      fmt::format(
          "{}[[channel]]\nname = \"t\"\nindex = {}\nrole = \"t\"\nunit = \"{}\"\n",
          interpolation_lines(in_unit(stamps, clock_units[likely]), rate_hz_of(step, stamps, clock_units[likely])),
          column, clock_units[likely].name));
}

void settle_unit(Stamps& stamps, int column, bool is_named, std::optional<double> rate_hz, std::vector<Check>& checks) {
  if (stamps.time_s.size() < 2) return;
  constexpr double least_mean_s = 0.4;  // of a clock whose usual step is a second or more, however uneven
  const double span_s = stamps.time_s.back() - stamps.time_s.front();
  const bool is_slow = span_s > least_mean_s * static_cast<double>(stamps.time_s.size());
  const bool is_fast = median(steps_of(stamps.time_s)) < shortest_step_s;
  if (is_named && !rate_hz && !((is_slow || is_fast) && is_clock_like(stamps.time_s)) && !unit_of_epoch(stamps)) return;
  const auto unit = unit_of_clock(stamps, column, rate_hz);
  if (!unit && is_named) return;
  if (!unit)
    throw Fault(FaultKind::input, "rate.mismatch",
                fmt::format("{}: column {} rises evenly as a clock does, by {:.6g} from row to row, but in no unit at "
                            "the {} Hz that the sidecar says. Correct the rate, or, if the column is a signal, give "
                            "it a [[channel]] with its index and role = \"other\"",
                            stamps.name, column, median(steps_of(stamps.time_s)), *rate_hz));
  if (!is_named || unit->in_s != 1.0)
    checks.push_back(
        {"clock.assumed", "", CheckStatus::note, unit->in_s, 0.0,
         fmt::format("{}: column {} rises evenly and was taken for the time in {}", stamps.name, column, unit->name)});
  stamps = in_unit(std::move(stamps), *unit);
}

}  // namespace dsp
