#pragma once
#include <Eigen/Core>
#include <Eigen/SVD>
#include <cassert>

namespace ident {

using SquareSvd = Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::NoQRPreconditioner>;

/// Singular values of a square matrix, such as a `triangle` (ident/r_factor.hpp), and what Eigen's `options` ask for.
/// Others are reduced to one first: Eigen's own reduction of them frees memory twice where an allocation fails.
inline SquareSvd square_svd(const Eigen::Ref<const Eigen::MatrixXd>& matrix, unsigned options = 0) {
  assert(matrix.rows() == matrix.cols());
  return SquareSvd(matrix, options);
}

}  // namespace ident
