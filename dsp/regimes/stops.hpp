#pragma once
#include <vector>

#include "dsp/regimes/regime.hpp"
#include "dsp/regimes/regime_signs.hpp"

namespace dsp {

/// Where the motion stops: in every run below twice options.stick_speed_m_per_s that gets below it, the speed is taken
/// on to zero as it falls and rises between the two. From zero to zero is how long it stands still; what passes
/// straight through zero takes no time. Held against its noise, and against how far below nothing such times lie in the
/// record, that says how much more probable a halt is; nothing where it lasts for less than a sample,
/// options.stick_duration_s or, of a coarse record, a period, or goes on as it came within a wave of the low-pass, as
/// what touches zero does. So does the acceleration at a reversal, and the clearer of the two counts; if both show a
/// halt, it lasts as long as either shows. Which are stops say the probabilities of all in a row (halt_rows.hpp). If
/// none are but while a force rests, these are pauses: what nothing drives rests, stuck or not; nor has it stopped
/// while it goes on swinging.
///
/// A stop begins sharply, and behind the low-pass the tangent of a sharp bend of the speed reaches zero later, by
/// 1 / pi^2 of a wave, which is taken off; it ends sharply or by degrees, as what pulls comes to exceed friction, and
/// its end is taken back to where the speed began to rise.
[[nodiscard]] std::vector<bool> stick_mask(const RegimeSigns& signs, const SegmentOptions& options);

/// Standard deviation of the ends of a stop: they lie anywhere in a wave of the low-pass, which blurs them.
[[nodiscard]] double stop_std_s(const RegimeSigns& signs);

}  // namespace dsp
