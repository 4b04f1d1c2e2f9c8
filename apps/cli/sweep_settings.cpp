#include "apps/cli/sweep_settings.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "apps/config/parameter_settings.hpp"
#include "apps/output/response_report.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/order_statistics.hpp"

namespace apps {

void refuse_sweep(const std::string& why) {
  throw dsp::Fault(dsp::FaultKind::usage, "frc.option", "frc: " + why);
}

namespace {

/// The largest of 1, 2 and 5 times a power of ten that is not above this.
double plain_below(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  return power * (value >= 5.0 * power ? 5.0 : value >= 2.0 * power ? 2.0 : 1.0);
}

/// To a tenth of its first digit.
double rounded(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return unit * std::round(value / unit);
}

/// From less than half the lowest frequency of free vibration to almost twice the highest, and over all steps; NaN:
/// there is neither.
std::pair<double, double> band_of(const std::optional<std::pair<double, double>>& free_hz,
                                  const std::vector<StepPoint>& steps) {
  constexpr double below = 0.45, above = 1.7;
  std::pair<double, double> band{dsp::nan, dsp::nan};
  if (free_hz) band = {rounded(below * free_hz->first), rounded(above * free_hz->second)};
  for (const StepPoint& step : steps)
    band = {std::fmin(band.first, step.frequency_hz), std::fmax(band.second, step.frequency_hz)};
  return band;
}

}  // namespace

Sweep sweep_of(const std::vector<std::string>& settings, const SweptEquation& equation,
               const std::vector<StepPoint>& steps) {
  Sweep result{.options = {}, .amplitude_measured = !steps.empty()};
  sim::FrequencyResponseOptions& sweep = result.options;
  std::tie(sweep.from_hz, sweep.to_hz) = band_of(equation.free_hz, steps);
  sweep.step_hz = dsp::nan;  // no setting is
  const char* amplitude = equation.drive == ident::DriveKind::base ? "amplitude_mm" : "amplitude";
  bool amplitude_given = equation.drive == ident::DriveKind::base || !steps.empty();
  if (!steps.empty()) {
    std::vector<double> drives;
    for (const StepPoint& step : steps) drives.push_back(step.drive);
    sweep.amplitude_m = dsp::median(std::move(drives));
  }
  for (const auto& [name, value] : parse_settings(settings)) {
    const bool known = name == amplitude || name == "from_hz" || name == "to_hz" || name == "step_hz";
    if (!known) refuse_sweep(fmt::format("no setting \"{}\"; there are from_hz, to_hz, step_hz, {}", name, amplitude));
    if (name == amplitude) result.amplitude_measured = false;
    if (name == "amplitude")
      sweep.amplitude_m = value, amplitude_given = true;
    else
      (void)set_sweep_option(sweep, name, value);
  }
  if (std::isnan(sweep.from_hz) || std::isnan(sweep.to_hz))
    refuse_sweep(equation.none_because +
                 ", and so no frequency to look about: give the sweep's, --set from_hz=... --set to_hz=...");
  if (std::isnan(sweep.step_hz)) sweep.step_hz = plain_below(0.005 * (sweep.from_hz + sweep.to_hz));
  if (!amplitude_given)
    refuse_sweep(fmt::format("the equation is driven by {}: give its amplitude, --set amplitude=...", equation.input));
  if (!(sweep.amplitude_m > 0.0))
    refuse_sweep(fmt::format("the amplitude must be positive, got {}", sweep.amplitude_m));
  return result;
}

}  // namespace apps
