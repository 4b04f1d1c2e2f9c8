#pragma once
#include "dsp/regimes/regime_signs.hpp"

namespace dsp {

/// Fills in stick_duration_s, stick_speed_m_per_s and, unless that was given, stick_halt_s where they are 0, with a
/// remark: rules at segment_regimes.
void choose_stick(const RegimeSigns& signs, Segmentation& result);

}  // namespace dsp
