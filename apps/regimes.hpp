#pragma once
#include <string>
#include <vector>

#include "dsp/prepare.hpp"
#include "dsp/segment_regimes.hpp"

namespace apps {

/// The regime of each sample at the regression rate.
[[nodiscard]] std::vector<dsp::Regime> regimes_at(const dsp::Segmentation& segmentation, const dsp::Prepared& prepared);

/// Power that seems to stay in one regime of motion, <v a> / (sigma_v sigma_a); NaN where it does not occur.
struct RegimePower {
  dsp::Regime regime;
  double raw = 0.0, corrected = 0.0;
};
using PowerCheck = std::vector<RegimePower>;  ///< one for each regime of motion

/// Before and after the sensors were brought to agree. `prepared` must hold raw_v and raw_a.
[[nodiscard]] PowerCheck power_check(const dsp::Prepared& prepared, const std::vector<dsp::Regime>& regimes);

/// Of one regime; NaN where it does not occur.
[[nodiscard]] RegimePower balance_in(const PowerCheck& power, dsp::Regime regime);
/// The largest magnitude in the regimes of a set, of what is raw or corrected; NaN where there is none.
[[nodiscard]] double largest_balance(const PowerCheck& power, const dsp::RegimeSet& regimes,
                                     double RegimePower::*which);

/// As a row of quality.json ("power.balance"): a warning where the raw signals are out of step.
[[nodiscard]] dsp::Check judged(const PowerCheck& power, const std::vector<dsp::SensorRelation>& relations);

}  // namespace apps
