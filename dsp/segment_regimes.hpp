#pragma once
#include <Eigen/Core>
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
};

/// Thresholds left at 0 are chosen from the record itself; the ones used come back in the Segmentation.
struct SegmentOptions {
  double stick_speed_m_per_s = 0.0;  ///< slower than this for stick_duration_s is a stop
  double stick_duration_s = 0.0;
  /// A reversal at which the motion halts for so long is a stop, too: see reversals.hpp. 0 where stick_speed_m_per_s is
  /// given or stops are not looked for: none is.
  double stick_halt_s = 0.0;
  double stick_margin_s = 0.0;     ///< stops are dilated by this to either side
  double high_enter_m = 0.0;       ///< the amplitude envelope above this is high,
  double high_leave_m = 0.0;       ///< until it falls below this
  double envelope_window_s = 2.0;  ///< envelope: half of max - min of x over this window,
  double baseline_window_s = 6.0;  ///< after its mean over this one is removed
  double min_duration_s = 10.0;    ///< shorter runs join the run to their left unless an exclusion or an end cuts them
};

/// Every sample has one label; segments follow one another without gap or overlap.
struct Segmentation {
  std::vector<Segment> segments;
  Eigen::VectorXd envelope_m;        ///< of x, one per sample
  SegmentOptions options;            ///< with every threshold filled in
  std::vector<std::string> remarks;  ///< how thresholds were chosen, in sentences
  std::optional<Mount> mount;        ///< of the sensors; none: not looked for, as segments are not from the record
};

/// Cuts a record into amplitude regimes from its relative displacement and velocity at the intermediate rate. `motion`
/// needs x and v; samples marked in motion.excluded get that label. Throws std::invalid_argument for negative
/// thresholds or high_leave_m above high_enter_m.
///
/// Thresholds from the record, T its dominant period:
/// - stick: |v|, low-passed at 6.5 / T, below 0.05 of the velocity amplitude that 97 of 100 cycles in motion exceed, or
///   below three times the noise of v (from the spectrum of x between 10 / T and 16 / T) where that is more, for T / 20
///   longer than passing through zero at that slope would take. None are looked for where three times the noise is more
///   than 0.3 of that amplitude (where most cycles rest: of the median of the others). Margins of 1 s; where the base
///   is still, of T / 6, because friction ends a free decay within seconds.
///   Where the base moves and v reaches less than that noise, or a fiftieth of the base's velocity, the payload is
///   taken to follow its base: all of that is stick.
/// - shorter stops, by the acceleration, where it is measured, or computed, up to 26 / T (38 Hz where that is above
///   16 / T): it keeps its sign while the velocity passes zero, and is zero while the payload halts. reversals.hpp
///   says what is detected. A mount that rings between body and sensors is looked for (mount.hpp) and its ringing taken
///   off first. What is slow for less than T / 4 but reverses at once by its acceleration is no stop.
/// - high, with a base: on the upper branch x moves in phase with r, on the lower one against it. high_enter is five
///   eighths of the amplitude that x settles to behind a jump up (kept within 2 %, else 5 %, for six periods; of
///   several jumps the geometric mean), where a jump is steepest, and at least 1.1 times what it had settled to before
///   (2.5 % for eighteen periods, else 5 % for six), excluded or not: what clipping leaves out lies right behind a
///   jump; without a jump, the median settled on the upper branch and the largest on the lower are taken instead.
///   high_leave is four fifths of the smallest settled on the upper branch, and below high_enter the motion is low
///   again as soon as it is against the base. All motion in phase: all above high_leave is high; never in phase, or
///   branches of one size (less than a fifth apart): all of it is low.
/// - high, without one: a jump is a growth of the envelope by half within six periods, not out of a stick, after ten
///   periods in which it kept within a factor of 1.5; high_enter is the geometric mean of the largest amplitude before
///   and the smallest after, high_leave 0.85 of the smallest on the upper branch. No jump: low.
[[nodiscard]] Segmentation segment_regimes(const Motion& motion, const SegmentOptions& options = {});

/// The regime of each sample of `signals`, the same motion as `intermediate` at a lower rate.
[[nodiscard]] std::vector<Regime> regimes_at(const Segmentation& segmentation, const Motion& intermediate,
                                             const Motion& signals);

}  // namespace dsp
