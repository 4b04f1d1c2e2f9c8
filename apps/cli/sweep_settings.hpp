#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/output/steps_table.hpp"
#include "ident/equation/equation_oscillator.hpp"
#include "sim/ode/frequency_response.hpp"

namespace apps {

/// Throws dsp::Fault (usage, "frc.option") that says why.
[[noreturn]] void refuse_sweep(const std::string& why);

struct Sweep {
  sim::FrequencyResponseOptions options;
  bool amplitude_measured = false;  ///< that of the record's steps
};

/// What a sweep is to look about.
struct SweptEquation {
  ident::DriveKind drive = ident::DriveKind::base;
  std::string input = "f";                           ///< that drives where it is a force
  std::optional<std::pair<double, double>> free_hz;  ///< lowest and highest frequency of free vibration
  std::string none_because = {};                     ///< where there is none
};

/// The sweep that settings of `ardent frc` ask for: from_hz, to_hz, step_hz, and amplitude_mm of the base, or amplitude
/// where a force drives. Left out, the amplitude is that of the record's steps, if it has some; the frequencies are
/// about those of free vibration and those of the steps. Throws dsp::Fault (usage, "frc.option"), and
/// std::invalid_argument as parse_settings.
[[nodiscard]] Sweep sweep_of(const std::vector<std::string>& settings, const SweptEquation& equation,
                             const std::vector<StepPoint>& steps = {});

}  // namespace apps
