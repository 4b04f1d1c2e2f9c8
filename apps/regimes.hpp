#pragma once
#include <string>
#include <vector>

#include "dsp/prepare.hpp"
#include "dsp/segment_regimes.hpp"

namespace apps {

/// Whether a sample of this regime belongs to a range of that one: as Range::regime.
[[nodiscard]] bool belongs(dsp::Regime regime, const std::string& wanted);

/// The regime of each sample at the regression rate.
[[nodiscard]] std::vector<dsp::Regime> regimes_at(const dsp::Segmentation& segmentation, const dsp::Prepared& prepared);

/// Power that seems to stay, <v a> / (sigma_v sigma_a), in each regime of motion; NaN where there is none.
struct PowerCheck {
  double raw_low = 0.0, raw_high = 0.0, corrected_low = 0.0, corrected_high = 0.0;
};

/// Before and after the sensors were brought to agree. `prepared` must hold raw_v and raw_a.
[[nodiscard]] PowerCheck power_check(const dsp::Prepared& prepared, const std::vector<dsp::Regime>& regimes);

/// The larger of the corrected ones in a regime as of Range; NaN where there is none.
[[nodiscard]] double corrected_balance(const PowerCheck& power, const std::string& regime);

/// As a row of quality.json ("power.balance"): a warning where the raw signals are out of step.
[[nodiscard]] dsp::Check judged(const PowerCheck& power, const std::vector<dsp::SensorRelation>& relations);

}  // namespace apps
