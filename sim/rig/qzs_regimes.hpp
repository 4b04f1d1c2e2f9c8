#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "sim/rig/qzs_rig.hpp"

namespace sim {

/// What the payload truly did from from_s to to_s: "stick", "low" (lower branch), "high" (upper branch) or "free": it
/// moves while its base is at rest, so there is no phase against it and no branch.
struct RegimeInterval {
  std::string label;
  double from_s = 0.0, to_s = 0.0;
};

/// From the exact motion of the rig, sampled from the programme's start on, as intervals in order without gaps. No
/// amplitude and no threshold is in it.
/// - The branch of a cycle of the base, from one zero of its exact r to the next but one, is the sign of the
///   correlation of x with r over it: in phase is high, antiphase low; between two cycles it changes where that
///   correlation is zero, linearly interpolated.
/// - While the drive is held (from a node of the programme, or from where a hand lets go, to the next), the branch
///   changes once at most: in the first cycle of the branch of the orbit on which the motion settles. That orbit is
///   found by integrating on with the drive of this interval held for longest_transient cycles. A payload that settles
///   locked is on the lower branch; while the drive falls to zero there is no orbit, and the branch stays as it is. One
///   that breaks loose, or starts, was on no orbit: if it reaches the one on which it settles while the drive is held,
///   it is on that branch from the start.
/// - Stick is the friction mode of the integrator, sample by sample; a slip shorter than a cycle of the programme's
///   frequency between two sticks belongs to them.
/// Throws std::invalid_argument unless there is one mode (QzsMode) for each x, and a rate.
[[nodiscard]] std::vector<RegimeInterval> true_regimes(const std::shared_ptr<const QzsRig>& rig,
                                                       const Eigen::Ref<const Eigen::VectorXd>& x,
                                                       const std::vector<int>& modes, double sample_rate_hz);

}  // namespace sim
