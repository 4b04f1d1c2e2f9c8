#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "apps/paper/section4.hpp"

namespace apps {

/// The noise that Section 4 states, a fraction of each target's standard deviation.
inline constexpr double stated_noise = 0.10;

/// What the paper prints for one row by one method, and what the stated method gives for the same terms without the
/// luck of a draw.
struct PrintedRow {
  std::vector<Eigen::Index> terms;  ///< of the case's library
  Eigen::VectorXd printed;
  Eigen::VectorXd expected;  ///< the truth; where none is known noise-free least squares on these terms
  Eigen::MatrixXd root;      ///< L of the covariance L L^T of an estimate under the stated noise
  /// Index among `terms`, their number where it is not there.
  [[nodiscard]] Eigen::Index position_of(Eigen::Index term) const;
};
/// `method`: "fast_rvm", "slow_rvm" or "sindy". `row`: one of the regression's.
[[nodiscard]] PrintedRow printed_row(const Section4Study& study, const Section4Regression& regression,
                                     const Section4Row& row, const std::string& method);

/// Index in the case's library of a term printed for it; the library's size where it is not there.
[[nodiscard]] Eigen::Index column_of(const Section4Study& study, const char* term);

}  // namespace apps
