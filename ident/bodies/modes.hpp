#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/bodies/candidates.hpp"

namespace ident {

/// A mode of the equations made linear about rest. Standard deviations to first order from those of the coefficients.
struct Mode {
  double frequency_hz = 0.0, frequency_std = 0.0;  ///< |lambda| / 2 pi
  double damping = 0.0, damping_std = 0.0;         ///< -Re lambda / |lambda|
  Eigen::VectorXd shape, shape_std;                ///< of each body, the largest 1; signs by phases below or above 90
  Eigen::VectorXd phase_deg;                       ///< of each body against the largest
};

/// Slowest first; those that swing, and none where the linear part cannot be had. `known`: coefficients of terms.
[[nodiscard]] std::vector<Mode> modes_of(const BodiesLayout& layout, const std::vector<BodyTerm>& terms,
                                         const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance);

}  // namespace ident
