#pragma once
#include <Eigen/Core>
#include <vector>

namespace dsp {

/// How many samples from either end of a record sign_changes leaves out: a quarter of a period.
[[nodiscard]] Eigen::Index sign_change_margin(Eigen::Index samples_per_period);

/// Where v changes its sign for good: changes within a twelfth of a period of one another are noise about one reversal
/// (its first change is kept, if the sign did change), and those closer than a sixth to others, or than
/// sign_change_margin to an end of the record, are left out.
[[nodiscard]] std::vector<Eigen::Index> sign_changes(const Eigen::VectorXd& v, Eigen::Index samples_per_period);

/// A velocity reversal.
struct Reversal {
  Eigen::Index at = 0;
  double halt_s = 0.0;  ///< how long the motion halts there, at least; 0: no halt is detected
};

struct ReversalOptions {
  double sample_rate_hz = 0.0;
  double cutoff_hz = 0.0;  ///< of the acceleration
  Eigen::Index samples_per_period = 0;
};

/// Looks at the acceleration a about each reversal, low-passed at cutoff_hz. Dry friction makes it leap there; if the
/// payload halts, it is zero in between. Halts of up to a wave of the band are fitted (halt_fit.hpp), at the record's
/// smaller accelerations, and believed where they explain more than chance: four standard deviations above what they
/// seem to explain at those reversals, and, unless it is twice that, where another halt lies within two periods; or in
/// rows, where the median of up to eleven explains three. The standard deviation is that of these reversals, and at
/// least that by noise. Longer ones are seen in the velocity: stops.hpp. From accelerometers at an intermediate rate of
/// 256 Hz halts of 1 to 2 ms are detected, at thirtyfold noise rows of some 3 ms. Where friction rises steadily towards
/// zero speed (Stribeck) every reversal dips, and only standing still is detected.
///
/// Left out are reversals whose acceleration stays below four times its noise or a hundredth of the record's. None are
/// found where cutoff_hz is less than twelve oscillations a period or does not fit sample_rate_hz.
[[nodiscard]] std::vector<Reversal> reversals(const std::vector<Eigen::Index>& reversal_indices,
                                              const Eigen::VectorXd& v, const Eigen::VectorXd& a,
                                              const ReversalOptions& options);

/// The shortest halt that is looked for.
[[nodiscard]] double shortest_halt_s(double cutoff_hz);

}  // namespace dsp
