#pragma once
#include <Eigen/Core>
#include <vector>

namespace dsp {

/// How many samples from either end of a record sign_changes leaves out: a wave of the low-pass that v is behind.
[[nodiscard]] Eigen::Index sign_change_margin(Eigen::Index samples_per_period);

/// Where v changes its sign for good: changes within half a wave of the low-pass of one another are noise about one
/// reversal (its first change is kept, if the sign did change), and those closer than a wave to others, or to an end of
/// the record, are left out.
[[nodiscard]] std::vector<Eigen::Index> sign_changes(const Eigen::VectorXd& v, Eigen::Index samples_per_period);

/// A velocity reversal.
struct Reversal {
  Eigen::Index at = 0;
  double halt_s = 0.0;     ///< how long the motion halts there, if it does
  double log_ratio = 0.0;  ///< logarithm of how much more probable a halt makes the acceleration; 0: it says nothing
};

struct ReversalOptions {
  double sample_rate_hz = 0.0;
  double cutoff_hz = 0.0;  ///< of the acceleration
};

/// Looks at the acceleration a about each reversal, low-passed at cutoff_hz. Dry friction makes it leap there; if the
/// payload halts, it is zero in between. Halts of up to a wave of the band are fitted (halt_fit.hpp), at the record's
/// smaller accelerations; how much more probable a halt is follows from what the fit gains, beside what it usually
/// gains, by how much these gains differ and what it leaves there. Which are believed say their neighbours:
/// halt_rows.hpp. Longer ones are seen in the velocity: stops.hpp. Where friction rises steadily towards zero speed
/// (Stribeck) every reversal dips, and only standing still is detected.
///
/// Left out are reversals of larger accelerations than usual, by a tenth of the median, and of less than a tenth of it.
[[nodiscard]] std::vector<Reversal> reversals(const std::vector<Eigen::Index>& reversal_indices,
                                              const Eigen::VectorXd& v, const Eigen::VectorXd& a,
                                              const ReversalOptions& options);

}  // namespace dsp
