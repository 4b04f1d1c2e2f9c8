#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/regression/fit.hpp"
#include "ident/regression/r_factor.hpp"

namespace ident {

/// A regression of q targets at unit norm: R's columns and targets divided by their 2-norms, so that nothing carries a
/// unit. The prior is scaled by the noise: lambda_i = alpha_i sigma^2. For fixed lambda the best sigma^2 then has a
/// closed form.
struct UnitProblem {
  Eigen::MatrixXd A;             ///< (b+q) x b, unit-norm columns (zero columns stay zero)
  Eigen::MatrixXd Y;             ///< (b+q) x q, unit-norm targets (zero targets stay zero)
  Eigen::VectorXd column_norm;   ///< b
  Eigen::VectorXd target_norm;   ///< q
  Eigen::Index num_samples = 0;  ///< m
  Eigen::VectorXd degree;        ///< b: those of the RFactor
  Poll poll;                     ///< called by whatever takes time of it
  [[nodiscard]] Eigen::Index num_terms() const { return A.cols(); }
  [[nodiscard]] Eigen::Index num_targets() const { return Y.cols(); }
};
/// Squared norm of what is left of a unit-norm column beyond others that is still more than rounding.
[[nodiscard]] double smallest_sparsity(const UnitProblem& problem);
[[nodiscard]] UnitProblem unit_problem(const RFactor& data, Poll poll = {});

/// Prior so wide (lambda of a unit-norm column) that the posterior is least squares. Best lambdas go with the square of
/// a sparsity, itself as small as the square of rounding: 1e-30 is below any that says something.
inline constexpr double flat_lambda = 1e-30;

/// All the marginal likelihood knows of a set of kept terms at given lambda, from a Householder QR of
/// [A_kept; sqrt(lambda)]. Sparsity and quality are residual norms and products: nothing is subtracted, unlike in
/// Eqs. 24-27 of [QZS23], which lose all digits at little noise.
struct Posterior {
  Eigen::MatrixXd mean;          ///< b' x q, Eq. 12 of [QZS23] at unit norm
  Eigen::MatrixXd root;          ///< b' x b'; covariance (Eq. 13) = sigma^2 root root'
  Eigen::VectorXd sparsity;      ///< b: sigma^2 k_i (Eq. 22) = squared norm of column i beyond the other kept columns
  Eigen::MatrixXd quality;       ///< b x q: sigma^2 l_i (Eq. 23)
  Eigen::MatrixXd misfit;        ///< q x q: sigma^2 T'Omega^-1 T = (Y - A mu)'(Y - A mu) + mu'diag(lambda) mu
  Eigen::MatrixXd residual;      ///< q x q: (Y - A mu)'(Y - A mu)
  double log_determinant = 0.0;  ///< log|Omega / sigma^2| of one target
};
[[nodiscard]] Posterior posterior(const UnitProblem& problem, const std::vector<Eigen::Index>& kept,
                                  const Eigen::VectorXd& lambda);

/// Covariance of the noise of q targets: its principal axes and the variances along them. Of one target: sigma^2.
struct NoiseCovariance {
  Eigen::MatrixXd axes;       ///< q x q, orthonormal columns
  Eigen::VectorXd variances;  ///< q
  /// Of errors whose products sum up to `products` (q x q) over `count` samples. Variances are at least `floor`, and
  /// 1e-14 of the largest: what is less is the rounding of a target that is a multiple of others.
  [[nodiscard]] static NoiseCovariance of(const Eigen::MatrixXd& products, double count, double floor);
  [[nodiscard]] Eigen::MatrixXd matrix() const { return axes * variances.asDiagonal() * axes.transpose(); }
};

/// Log marginal likelihood (Eq. 15 of [QZS23]) of the targets in their own units; the noise is that at unit norm.
[[nodiscard]] double log_evidence(const UnitProblem& problem, const Posterior& at, const NoiseCovariance& noise);
[[nodiscard]] double log_evidence(const UnitProblem& problem, const Posterior& at, double noise_variance);

/// 2 dL of having a term at its best alpha instead of not at all: q - 1 - log q with q = l^2 / k, zero for q <= 1.
[[nodiscard]] double evidence_gain(double q);
/// Probability that a term with this gain belongs, where the model without it is as likely at a gain of tau.
[[nodiscard]] double probability_of(double gain, double tau);
/// 2 f(alpha) of Eq. 21 of [QZS23]: 2 dL of having a term at this lambda instead of not at all. Here and below
/// sparsity is sigma^2 k and quality2 is sigma^2 l^2.
[[nodiscard]] double evidence_contribution(double sparsity, double quality2, double lambda);
/// Eqs. 29-30 of [QZS23], noise-scaled; infinite where l^2 <= k.
[[nodiscard]] double best_lambda(double sparsity, double quality2);

/// What a term's gain must exceed: `tau` if it is not negative, else the selection's own, which is
/// ln m + 2 ln b for Selection::evidence, so that b candidates rarely let a false one in, and 0 for Selection::type2.
[[nodiscard]] double gain_threshold(Selection selection, double tau, Eigen::Index num_samples, Eigen::Index num_terms);

}  // namespace ident
