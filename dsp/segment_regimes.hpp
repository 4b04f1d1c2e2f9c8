#pragma once
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "dsp/motion.hpp"
#include "dsp/regimes/regime.hpp"
#include "dsp/sensors/mount.hpp"

namespace dsp {

/// Samples [first, last) of one label.
struct Segment {
  Regime regime = Regime::low;
  Eigen::Index first = 0, last = 0;
  std::string reason;
  double probability = std::numeric_limits<double>::quiet_NaN();  ///< of the branch of low and high; NaN: not estimated
  /// Standard deviations of its ends; NaN: not estimated, as where an exclusion or the record ends.
  double first_std_s = std::numeric_limits<double>::quiet_NaN(), last_std_s = first_std_s;
};

/// Thresholds left at 0 are chosen from the record itself; the ones used come back in the Segmentation.
struct SegmentOptions {
  double stick_speed_m_per_s = 0.0;  ///< what comes to rest is looked for below this; given, nothing else shows it
  double stick_duration_s = 0.0;     ///< what halts for shorter is a reversal; 0: what noise and band allow to tell
  double high_amplitude_m = 0.0;     ///< an amplitude of x above this is high; 0: the branch is seen in the phase
};

/// Every sample has one label; segments follow one another without gap or overlap.
struct Segmentation {
  std::vector<Segment> segments;
  SegmentOptions options;            ///< with every threshold filled in
  std::vector<std::string> remarks;  ///< how thresholds were chosen, in sentences
  std::optional<Mount> mount;        ///< of the sensors; none: not looked for, as segments are not from the record
};

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
