#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/r_factor.hpp"

namespace ident {

/// One regression at unit norm: R's columns and target divided by their 2-norms, so that nothing carries a unit.
/// The prior is scaled by the noise: lambda_i = alpha_i sigma^2. For fixed lambda the best sigma^2 then has a closed
/// form.
struct UnitProblem {
  Eigen::MatrixXd A;            ///< (b+q) x b, unit-norm columns (zero columns stay zero)
  Eigen::VectorXd y;            ///< b+q, unit norm (zero if the target is zero)
  Eigen::VectorXd column_norm;  ///< b
  double target_norm = 0.0;
  Eigen::Index num_samples = 0;  ///< m
  [[nodiscard]] Eigen::Index num_terms() const { return A.cols(); }
};
[[nodiscard]] UnitProblem unit_problem(const RFactor& data, Eigen::Index target = 0);

/// All the marginal likelihood knows of a set of kept terms at given lambda, from a Householder QR of
/// [A_kept; sqrt(lambda)]. Sparsity and quality are residual norms and products: nothing is subtracted.
struct Posterior {
  Eigen::VectorXd mean;          ///< b', Eq. 12 of [QZS23] at unit norm
  Eigen::MatrixXd root;          ///< b' x b'; covariance (Eq. 13) = sigma^2 root root'
  Eigen::VectorXd sparsity;      ///< b: sigma^2 k_i (Eq. 22) = squared norm of column i beyond the other kept columns
  Eigen::VectorXd quality;       ///< b: sigma^2 l_i (Eq. 23)
  double misfit = 0.0;           ///< sigma^2 t'Omega^-1 t = ||y - A mu||^2 + sum lambda mu^2
  double residual = 0.0;         ///< ||y - A mu||^2
  double log_determinant = 0.0;  ///< log|Omega / sigma^2|
};
[[nodiscard]] Posterior posterior(const UnitProblem& problem, const std::vector<Eigen::Index>& kept,
                                  const Eigen::VectorXd& lambda);

/// Log marginal likelihood (Eq. 15 of [QZS23]) of the target in its own unit; `noise_variance` is at unit norm.
[[nodiscard]] double log_evidence(const UnitProblem& problem, const Posterior& at, double noise_variance);

/// 2 dL of having a term at its best alpha instead of not at all: q - 1 - log q with q = l^2 / k, zero for q <= 1.
[[nodiscard]] double evidence_gain(double q);
/// 2 f(alpha) of Eq. 21 of [QZS23]: 2 dL of having a term at this lambda instead of not at all.
[[nodiscard]] double evidence_share(double sparsity, double quality, double lambda, double noise_variance);
/// Eq. 29 of [QZS23], noise-scaled; infinite where q <= 1.
[[nodiscard]] double best_lambda(double sparsity, double quality, double noise_variance);

/// ln m + 2 ln b: what a term's gain must exceed so that b candidates rarely let a false one in.
[[nodiscard]] double default_tau(Eigen::Index num_samples, Eigen::Index num_terms);

}  // namespace ident
