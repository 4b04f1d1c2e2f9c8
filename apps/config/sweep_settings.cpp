#include "apps/config/sweep_settings.hpp"

#include <fmt/format.h>

#include <utility>

#include "apps/config/parameter_settings.hpp"
#include "apps/output/response_report.hpp"
#include "dsp/fault.hpp"
#include "dsp/order_statistics.hpp"

namespace apps {

void refuse_sweep(const std::string& why) {
  throw dsp::Fault(dsp::FaultKind::usage, "frc.option", "frc: " + why);
}

sim::FrequencyResponseOptions sweep_of(const std::vector<std::string>& settings, ident::DriveKind drive,
                                       const std::vector<StepPoint>& steps) {
  sim::FrequencyResponseOptions sweep;
  const char* amplitude = drive == ident::DriveKind::base ? "amplitude_mm" : "amplitude";
  bool amplitude_given = drive == ident::DriveKind::base || !steps.empty();
  if (!steps.empty()) {
    std::vector<double> drives;
    for (const StepPoint& step : steps) drives.push_back(step.drive);
    sweep.amplitude_m = dsp::median(std::move(drives));
  }
  for (const auto& [name, value] : parse_settings(settings)) {
    const bool known = name == amplitude || name == "from_hz" || name == "to_hz" || name == "step_hz";
    if (!known) refuse_sweep(fmt::format("no setting \"{}\"; there are from_hz, to_hz, step_hz, {}", name, amplitude));
    if (name == "amplitude")
      sweep.amplitude_m = value, amplitude_given = true;
    else
      (void)set_sweep_option(sweep, name, value);
  }
  if (!amplitude_given) refuse_sweep("the equation is driven by f: give its amplitude, --set amplitude=...");
  if (!(sweep.amplitude_m > 0.0))
    refuse_sweep(fmt::format("the amplitude must be positive, got {}", sweep.amplitude_m));
  return sweep;
}

}  // namespace apps
