#include "ident/state_space/scatter.hpp"

#include <Eigen/Core>

namespace ident::state_space {

std::vector<double> scatter_covariance(const Linear& linear, const Noise& noise,
                                       const std::vector<double>& covariance) {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  // So many that a variance is known within a quarter, so few that each is long against the memory of a misfit.
  constexpr int num_stretches = 32;
  constexpr double degrees_of_freedom = num_stretches - 1;
  constexpr double of_student = 2.0395 / 1.96;  // the 97.5 % quantile of so many degrees of freedom over the normal one
  const auto p = std::ssize(linear.parameters);
  const std::vector<double> slopes = slopes_of_stretches(linear, noise, num_stretches);
  Rows scatter = Rows::Map(slopes.data(), num_stretches, p);
  scatter.rowwise() -= scatter.colwise().mean().eval();
  Rows between = scatter.transpose() * scatter * (num_stretches / degrees_of_freedom);
  between.diagonal() += Eigen::VectorXd::Map(linear.prior_weights.data(), p).cwiseAbs2();
  const auto inverse_curvature = Rows::Map(covariance.data(), p, p);
  std::vector<double> result(covariance.size());
  Rows::Map(result.data(), p, p) = of_student * of_student * (inverse_curvature * between * inverse_curvature);
  return result;
}

}  // namespace ident::state_space
