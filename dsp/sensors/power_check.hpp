#pragma once
#include <vector>

#include "dsp/prepare.hpp"
#include "dsp/segment_regimes.hpp"

namespace dsp {

/// Power that seems to stay, <v a> / (sigma_v sigma_a), in each regime of motion: zero in steady motion but for what
/// velocity and acceleration are out of step. NaN where there is no such regime.
struct PowerCheck {
  double raw_low = 0.0, raw_high = 0.0, corrected_low = 0.0, corrected_high = 0.0;
};

/// Before and after the relations between the sensors were used. `prepared` must hold raw_v and raw_a; `regimes`: of
/// each sample at the regression rate.
[[nodiscard]] PowerCheck power_check(const Prepared& prepared, const std::vector<Regime>& regimes);

/// As a row of quality.json ("power.balance"): a warning where the raw signals are out of step.
[[nodiscard]] Check check_of(const PowerCheck& power, const std::vector<SensorRelation>& relations);

}  // namespace dsp
