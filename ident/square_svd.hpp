#pragma once
#include <Eigen/SVD>

namespace ident {

/// Singular values and vectors of a square matrix, such as a `triangle` (ident/r_factor.hpp). Others are reduced to one
/// first: Eigen's own reduction of them frees memory twice where an allocation fails.
using SquareSvd = Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::NoQRPreconditioner>;

}  // namespace ident
