#pragma once
#include <Eigen/Core>
#include <vector>

namespace dsp {

/// One column that is the time derivative of another, as far as their numbers tell.
struct FoundDerivative {
  Eigen::Index of = 0, is = 0;  ///< column `is` = factor x d(column `of`)/dt
  double factor = 1.0;          ///< near a power of ten: what units make
};

/// Pairs among columns that nobody named. The rise of one over a span must follow the other's mean over it, at the span
/// where both agree best, with a correlation of 0.99, and by a factor within 2 % of a power of ten: a force at
/// resonance follows the velocity, too, but not in a unit of it. Of a column that could be several's derivative the
/// best correlated is given. Gaps and constant columns are nobody's.
[[nodiscard]] std::vector<FoundDerivative> find_derivatives(const Eigen::MatrixXd& samples, double sample_rate_hz);

}  // namespace dsp
