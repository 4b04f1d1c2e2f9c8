#pragma once
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "dsp/regimes/half_cycles.hpp"

namespace dsp {

/// From sample `first` on the response is on the upper branch, or on the lower one.
struct BranchInterval {
  Eigen::Index first = 0;
  bool upper = false;
  double probability = 1.0;  ///< mean over its half cycles
  /// Standard deviation of its beginning; NaN where it began while the payload was held, and for the first.
  double first_std_s = std::numeric_limits<double>::quiet_NaN();
};

struct Branches {
  std::vector<BranchInterval> intervals;  ///< in order; at least one
  std::string remark;                     ///< how they were decided, in a sentence
};

/// On the upper branch of a resonance x moves in phase with what drives it, on the lower one against it. A switching
/// model of two states: the phase of a half cycle has a von Mises density about 0 or pi whose concentration, and the
/// probability of a switch, follow from the record by expectation maximisation; noise lowers the concentration. A half
/// cycle that is `held` shows nothing, and where it is for half of it what follows is guessed evenly; one that is
/// `excluded` may show nothing, but the payload moves on in it, as where a swing overshoots a sensor's range. A
/// switch is where the correlation of x with the drive passes zero, between the middles of two half cycles linearly;
/// its standard deviation is that of the crossings it may be instead, by their probabilities, and of that place by
/// noise, and by sampling and a lag between the sensors of up to half a sample.
///
/// Out of a rest a response is on no branch but on its way to one: from the start it is on that which it is on when its
/// drive changes its cycle by more than a sample or its level by more than noise, but not before ten cycles; one that
/// rests again before says itself where it is.
///
/// Of a spring that softens, or a force that counts against x, the phases are the other way round: the upper branch is
/// the one that the amplitude jumps up to.
///
/// There are two branches if the amplitude jumps where the phase turns: if its logarithm changes there, from ten cycles
/// before to ten behind, as it does nowhere else, by the Akaike information criterion.
/// Otherwise, as in a resonance without jumps and under random excitation, all is one branch: that of the mean phase.
[[nodiscard]] Branches find_branches(std::span<const HalfCycle> half_cycles, const std::vector<bool>& held,
                                     const std::vector<unsigned char>& excluded, double sample_rate_hz);

/// The same from amplitudes alone: above high_amplitude is the upper branch, by as many standard deviations as the
/// logarithm of the amplitude changes from a half cycle to the next.
[[nodiscard]] Branches branches_by_amplitude(std::span<const HalfCycle> half_cycles, double high_amplitude,
                                             double sample_rate_hz);

}  // namespace dsp
