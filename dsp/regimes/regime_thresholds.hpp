#pragma once
#include "dsp/regimes/regime.hpp"
#include "dsp/regimes/regime_signs.hpp"

namespace dsp {

/// Fills in stick_speed_m_per_s where it is 0, with a remark: rules at segment_regimes.
void choose_stick(const RegimeSigns& signs, Segmentation& result);

}  // namespace dsp
