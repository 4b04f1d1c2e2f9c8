#include "dsp/io/found_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "dsp/fault.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/io/table_layout.hpp"
#include "dsp/order_statistics.hpp"

namespace dsp {
namespace {

const std::array<ClockUnit, 4> clock_units{{{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}}};

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

std::optional<ClockUnit> unit_of_epoch(const Stamps& stamps) {
  constexpr double from_s = 3.2e8, to_s = 4e9;  // 1980 to 2096
  constexpr double slowest_step_s = 10.0;       // or it counts something else
  const double step = median(steps_of(stamps.time_s));
  for (const ClockUnit& unit : clock_units)
    if (stamps.time_s.front() * unit.in_s > from_s && stamps.time_s.back() * unit.in_s < to_s && step > 0.0 &&
        step * unit.in_s < slowest_step_s)
      return unit;
  return std::nullopt;
}

std::optional<ClockUnit> unit_of_clock(const Stamps& stamps, int column, std::optional<double> rate_hz) {
  constexpr double agreeing = 0.02;  // the middle step of a coarse clock is not its mean
  const double step = median(steps_of(stamps.time_s));
  if (rate_hz) {
    const auto found = std::find_if(clock_units.begin(), clock_units.end(), [&](const ClockUnit& unit) {
      return std::abs(step * unit.in_s * *rate_hz - 1.0) < agreeing;
    });
    return found == clock_units.end() ? std::nullopt : std::optional(*found);
  }
  if (const auto epoch = unit_of_epoch(stamps)) return epoch;
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
  if (is_named && !rate_hz && !(is_slow && is_clock_like(stamps.time_s)) && !unit_of_epoch(stamps)) return;
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
