#pragma once
#include <vector>

#include "dsp/prepare.hpp"
#include "dsp/segment_regimes.hpp"

namespace apps {

/// The regime of each sample at the regression rate.
[[nodiscard]] std::vector<dsp::Regime> regimes_at(const dsp::Segmentation& segmentation, const dsp::Prepared& prepared);

/// Power that seems to stay, <v a> / (sigma_v sigma_a), in each regime of motion; NaN where there is none.
struct PowerCheck {
  double raw_low = 0.0, raw_high = 0.0, corrected_low = 0.0, corrected_high = 0.0;
};

/// Before and after the sensors were brought to agree. `prepared` must hold raw_v and raw_a.
[[nodiscard]] PowerCheck power_check(const dsp::Prepared& prepared, const std::vector<dsp::Regime>& regimes);

/// As a row of quality.json ("power.balance"): a warning where the raw signals are out of step.
[[nodiscard]] dsp::Check judged(const PowerCheck& power);

}  // namespace apps
