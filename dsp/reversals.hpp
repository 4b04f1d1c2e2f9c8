#pragma once
#include <Eigen/Core>
#include <vector>

namespace dsp {

/// A place where a motion turns.
struct Reversal {
  Eigen::Index at = 0;
  /// Least acceleration there as a share of that on either side: near 1 where the motion turns at once, however
  /// friction changes its force, and near 0 where it halts, for what halts is not accelerated.
  double acceleration_share = 1.0;
  bool brief = false;  ///< over three times as long the dip is less than 0.6 as deep: an edge on either side
};

/// Where v changes its sign, by the acceleration a towards the new sign, averaged over a sixtieth of a period (at least
/// three samples): its least value within a fortieth of a period over the smaller of its largest values within an
/// eighth before and after. Left out is what cannot be told: reversals closer than a sixth of a period to another or a
/// quarter to an end of the record, and accelerations below four times the noise of a or a twentieth of the record's.
[[nodiscard]] std::vector<Reversal> reversals(const Eigen::VectorXd& v, const Eigen::VectorXd& a,
                                              Eigen::Index samples_per_period);

/// Share below which a reversal may be a halt: nine robust deviations below the median of those above a half, at most
/// 0.8. At least 0: where plain reversals scatter so widely (noise, a sensor on a mount that rings), none is told
/// apart.
[[nodiscard]] double halting_share(const std::vector<Reversal>& reversals);

/// Below this share, and either brief or below a half: a halt shorter than the average leaves a shallow dip, but so
/// does a slow swing of the acceleration.
[[nodiscard]] bool is_halt(const Reversal& reversal, double halting_share);

}  // namespace dsp
