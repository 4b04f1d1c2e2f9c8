#pragma once
#include <vector>

#include "dsp/regimes/regime.hpp"
#include "dsp/sensors/motion.hpp"

namespace dsp {

/// Cuts a record into amplitude regimes from its relative displacement and velocity at the intermediate rate. `motion`
/// needs x and v; samples marked in motion.excluded get that label. Throws std::invalid_argument for negative
/// thresholds.
///
/// Thresholds from the record, T its dominant period:
/// - stick: where |v|, of displacement and acceleration sensors together (joint_velocity.hpp) within the motion's
///   harmonics (harmonics.hpp), shows a halt (stops.hpp): below what sensors agree within, 0.03 of its own amplitude
///   or of the base's where that is more, or below three times its noise, it takes longer than passing through zero at
///   that slope does. None are looked for where its amplitude is less than four times that, or eight times where noise
///   sets it; but where the base moves and v does not reach the threshold, the payload follows its base, and all of it
///   is stick. Amplitude is that of a sine of the same mean speed. The ends of a stop have a standard deviation of T /
///   21.
/// - or the acceleration does, where it is measured, or computed, up to 20 / T: it keeps its sign while the velocity
///   passes zero, and is zero while the payload halts (reversals.hpp). A mount that rings between body and sensors is
///   looked for (mount.hpp); its ringing is taken off v, and this is not looked at.
/// - halts come in rows (halt_rows.hpp): a weak one beside clear ones is believed, one alone must be clear.
/// - what nothing drives, and goes on swinging beyond noise, has not stopped, however small it has become.
/// - what moves for less than a cycle between two stops is part of them: a payload that halts does so twice a cycle.
///
/// Low and high are the lower and upper branch of a resonance: branches.hpp. Without a base or a force there is no
/// phase to see them by, and all motion is low unless high_amplitude_m is given.
[[nodiscard]] Segmentation segment_regimes(const Motion& motion, const SegmentOptions& options = {});

/// The regime of each sample of `signals`, the same motion as `intermediate` at a lower rate.
[[nodiscard]] std::vector<Regime> regimes_at(const Segmentation& segmentation, const Motion& intermediate,
                                             const Motion& signals);

}  // namespace dsp
