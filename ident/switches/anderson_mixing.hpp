#pragma once
#include <Eigen/Core>
#include <utility>

namespace ident {

/// Solves x = g(x) where to go on with g(x) would take long, or swing about the solution for ever. All g(x) so far are
/// combined as their steps g(x) - x cancel best by least squares (Anderson's mixing [WN11, algorithm AA]): of a linear
/// g with k eigenvalues the solution after k + 1 of them. As many are remembered as g has entries that are not 0.
class AndersonMixing {
 public:
  /// `scale`: what each entry of x counts for, beside the others; finite.
  explicit AndersonMixing(Eigen::VectorXd scale) : scale_(std::move(scale)) {}
  /// The x to try next, from the last one tried and g of it. The first is g itself.
  [[nodiscard]] Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& g);

 private:
  Eigen::VectorXd scale_;
  Eigen::VectorXd last_step_, last_g_;  ///< steps are scaled
  Eigen::MatrixXd steps_, gs_;          ///< how they changed from each pass to the next
};

}  // namespace ident
