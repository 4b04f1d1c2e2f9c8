#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/regression/fit.hpp"

namespace ident {

/// q targets on one library with one relevance per term: T = Phi C + E with rows of E ~ N(0, Omega) and rows
/// c_i ~ N(0, Omega / lambda_i) (matrix normal; lambda = alpha scaled by the noise). Sharing the relevance keeps every
/// term any target needs in all of them, so a fit of each target on the shared terms follows. In the caller's units.
struct MultiFit {
  FitStatus status = FitStatus::converged;
  std::vector<Eigen::Index> relevant;  ///< b' shared terms: indices into the columns of the RFactor, ascending
  Eigen::MatrixXd mean;                ///< b' x q
  Eigen::MatrixXd row_covariance;      ///< Sigma (b' x b') = (Phi'Phi + diag lambda)^-1, free of the noise
  Eigen::MatrixXd noise_covariance;    ///< Omega (q x q)
  Eigen::VectorXd lambda;              ///< b'
  double log_evidence = 0.0;           ///< of all targets together
  double tau = 0.0;                    ///< what the gain of a term in all targets together had to exceed
  int iterations = 0;
  std::vector<FitStep> steps;  ///< noise_variance there: the geometric mean of Omega's eigenvalues
  std::vector<Fit> rows;       ///< q: each target alone on the shared terms, indices into the library
  /// b' x q: standard deviation of coefficient i of target j, sqrt(Omega_jj Sigma_ii). The published code, and the
  /// tables of [QZS23] made with it, leave out Omega.
  [[nodiscard]] Eigen::MatrixXd standard_deviation() const;
};

/// Multi-output form of fit_fast_rvm (the model of [HZ17], with the noise covariance estimated in closed form), by the
/// same search: a term's gain is q (g - 1 - log g), g = l Omega^-1 l' / (q k), and must exceed tau.
/// Any number of targets from one; where one of them cannot be fitted (all zero, say) none is.
/// Throws std::invalid_argument for an initial_noise_fraction outside (0, 1).
[[nodiscard]] MultiFit fit_multi_rvm(const RFactor& data, const MultiRvmOptions& options = {});

}  // namespace ident
