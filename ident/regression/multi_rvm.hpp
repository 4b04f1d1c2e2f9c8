#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/fit.hpp"

namespace ident {

/// Several targets on one library with one relevance per term: T = Phi C + E with rows of E ~ N(0, Omega) and rows
/// c_i ~ N(0, Omega / lambda_i) (matrix normal; lambda = alpha scaled by the noise). Sharing the relevance keeps every
/// term any target needs in all of them, so a fit of each row on the shared terms follows.
struct MultiFit {
  FitStatus status = FitStatus::converged;
  std::vector<Eigen::Index> relevant;  ///< b' shared terms, ascending
  Eigen::MatrixXd mean;                ///< b' x q
  Eigen::MatrixXd row_covariance;      ///< Sigma (b' x b') = (Phi'Phi + diag lambda)^-1, free of the noise
  Eigen::MatrixXd noise_covariance;    ///< Omega (q x q)
  Eigen::VectorXd lambda;              ///< b'
  double log_evidence = 0.0, tau = 0.0;
  int iterations = 0;
  std::vector<FitStep> steps;  ///< noise_variance there: the geometric mean of Omega's eigenvalues
  std::vector<Fit> rows;       ///< q: each target alone on the shared terms, indices into the library
  /// b' x q: sd of coefficient i of target j, sqrt(Omega_jj Sigma_ii). The published code, and the tables made with it,
  /// leave out Omega.
  [[nodiscard]] Eigen::MatrixXd standard_deviation() const;
};

/// Multi-output form of fit_fast_rvm (Ha and Zhang 2017's model, with the noise covariance estimated in closed form).
/// A term's gain is q (g - 1 - log g), g = l Omega^-1 l' / (q k), and must exceed tau.
[[nodiscard]] MultiFit fit_multi_rvm(const RFactor& data, const MultiRvmOptions& options = {});

}  // namespace ident
