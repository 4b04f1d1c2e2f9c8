#include "ident/equation/identified_equation.hpp"

#include "dsp/values/linear.hpp"
#include "sim/noise.hpp"

namespace ident {

Eigen::VectorXd drawn_coefficients(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance, std::uint64_t seed,
                                   std::uint64_t draw) {
  const Eigen::Index size = mean.size();
  // Coefficients differ by many powers of ten: the root is taken of their correlations.
  const Eigen::VectorXd deviation = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd inverse = deviation.unaryExpr([](double d) { return d > 0.0 ? 1.0 / d : 0.0; });
  const dsp::Axes axes = dsp::eigen_symmetric(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  const sim::Noise noise(seed, draw);
  Eigen::VectorXd z(size);
  for (Eigen::Index i = 0; i < size; ++i) z[i] = noise.normal(static_cast<std::uint64_t>(i));
  const Eigen::VectorXd spread = axes.values.cwiseMax(0.0).cwiseSqrt();
  return mean + deviation.cwiseProduct(axes.vectors * spread.cwiseProduct(axes.vectors.transpose() * z));
}

}  // namespace ident
