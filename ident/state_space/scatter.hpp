#pragma once
#include <vector>

#include "ident/state_space/smoother.hpp"

namespace ident::state_space {

/// Covariance of the parameters by how the slopes of the likelihood scatter from stretch to stretch of the records:
/// what an equation does not explain and comes back for longer than a sample counts in it, as it does not in
/// `covariance`, the inverse of the curvature. Where the equation is right both are the same. A misfit that is the
/// same in every stretch, as of a term that is missing, does not show. [Whi82, theorem 3.2]
[[nodiscard]] std::vector<double> scatter_covariance(const Linear& linear, const Noise& noise,
                                                     const std::vector<double>& covariance);

}  // namespace ident::state_space
