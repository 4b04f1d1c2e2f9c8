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

const std::array<ClockUnit, 3> clock_units{{{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}}};

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

std::optional<ClockUnit> unit_of_clock(const Stamps& stamps, int column, std::optional<double> rate_hz) {
  constexpr double agreeing = 0.02;  // the middle step of a coarse clock is not its mean
  const double step = median(steps_of(stamps.time_s));
  if (rate_hz) {
    const auto found = std::find_if(clock_units.begin(), clock_units.end(), [&](const ClockUnit& unit) {
      return std::abs(step * unit.in_s * *rate_hz - 1.0) < agreeing;
    });
    return found == clock_units.end() ? std::nullopt : std::optional(*found);
  }
  if (step < 1.0) return clock_units[0];
  const double ms_hz = rate_hz_of(step, stamps, clock_units[1]), us_hz = rate_hz_of(step, stamps, clock_units[2]);
  constexpr double slowest_hz = 10.0;  // of a recorder of vibration
  const std::size_t likely = ms_hz < slowest_hz ? 2 : 1;
  throw Fault(
      FaultKind::input, "clock.unit",
      fmt::format("{}: column {} rises by {:.6g} from row to row and seems to be the time. In seconds that would "
                  "be {:.3g} Hz, in ms {:.6g} Hz, in us {:.6g} Hz. Say which it is in {}, its first lines:",
                  stamps.name, column, step, 1.0 / step, ms_hz, us_hz, sidecar_path(stamps.name).string()),
      fmt::format("{}[[channel]]\nname = \"t\"\nindex = {}\nrole = \"t\"\nunit = \"{}\"\n",
                  interpolation_lines(in_unit(stamps, clock_units[likely]), likely == 2 ? us_hz : ms_hz), column,
                  clock_units[likely].name));
}

}  // namespace dsp
