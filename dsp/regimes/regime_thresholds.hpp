#pragma once
#include "dsp/regimes/regime_signs.hpp"

namespace dsp {

/// Fills in stick_duration_s, stick_speed_m_per_s and, unless that was given, stick_halt_s where they are 0, with a
/// remark: rules at segment_regimes.
void choose_stick(const RegimeSigns& signs, Segmentation& result);

/// Fills in high_enter_m and high_leave_m likewise; infinity where all motion is of one regime.
void choose_high(const RegimeSigns& signs, const std::vector<bool>& stuck, Segmentation& result);

/// Whether x moves clearly against the base: below resonance's amplitude branch, whatever the envelope says.
[[nodiscard]] bool against_base(const RegimeSigns& signs, Eigen::Index sample);

}  // namespace dsp
