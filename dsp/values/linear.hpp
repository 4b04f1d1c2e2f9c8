#pragma once
#include <Eigen/Core>

/// Factorisations of small dense matrices, by Eigen's, compiled once. Rows of whole recordings are folded into a
/// triangle first (ident/regression/r_factor.hpp). What is not finite gives what is not finite; nothing is thrown but
/// std::bad_alloc.
namespace dsp {

/// A = Q R by Householder's reflections, A m x n with m >= n.
class Qr {
 public:
  explicit Qr(Eigen::MatrixXd A);
  /// R, n x n: zero below the diagonal, whose signs are the reflections'.
  [[nodiscard]] Eigen::MatrixXd triangle() const;
  /// The first n columns of Q.
  [[nodiscard]] Eigen::MatrixXd basis() const;
  /// B of m rows becomes Q'B, Q with all its m columns.
  void rotate(Eigen::Ref<Eigen::MatrixXd> B) const;

 private:
  Eigen::MatrixXd reflections_;  ///< below the diagonal; R on and above it
  Eigen::VectorXd factors_;      ///< of each reflection
};

/// R^-1 B and R'^-1 B for an upper triangle: what is below the diagonal is not read.
[[nodiscard]] Eigen::VectorXd solve_upper(const Eigen::Ref<const Eigen::MatrixXd>& R, const Eigen::VectorXd& b);
[[nodiscard]] Eigen::MatrixXd solve_upper(const Eigen::Ref<const Eigen::MatrixXd>& R, const Eigen::MatrixXd& B);
[[nodiscard]] Eigen::VectorXd solve_transposed(const Eigen::Ref<const Eigen::MatrixXd>& R, const Eigen::VectorXd& b);
[[nodiscard]] Eigen::MatrixXd solve_transposed(const Eigen::Ref<const Eigen::MatrixXd>& R, const Eigen::MatrixXd& B);
[[nodiscard]] Eigen::MatrixXd inverse_of_upper(const Eigen::Ref<const Eigen::MatrixXd>& R);

/// The x of least norm of those with least |A x - b|, by a rank-revealing QR. A is m x n, of any shape.
[[nodiscard]] Eigen::VectorXd least_squares(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::VectorXd& b);

/// A^-1 b and A^-1 of a symmetric matrix that is not indefinite, by Cholesky's L D L' with pivots. Of a singular one a
/// solution in the space of its columns, as if b were there.
[[nodiscard]] Eigen::VectorXd solve_symmetric(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::VectorXd& b);
[[nodiscard]] Eigen::MatrixXd inverse_of_symmetric(const Eigen::Ref<const Eigen::MatrixXd>& A);

/// A^-1 by its determinant.
[[nodiscard]] Eigen::Matrix2d inverse_of(const Eigen::Matrix2d& A);

/// Eigenvalues or singular values, and their vectors, a column each.
struct Axes {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
/// A = V diag(values) V' of a symmetric matrix, the least first.
[[nodiscard]] Axes eigen_symmetric(const Eigen::Ref<const Eigen::MatrixXd>& A);

/// Singular values of a square matrix, the largest first, and its left or right vectors. Reduce others to a triangle
/// first: Eigen's own reduction of them frees memory twice where an allocation fails.
[[nodiscard]] Eigen::VectorXd singular_values(const Eigen::Ref<const Eigen::MatrixXd>& A);
[[nodiscard]] Axes left_singular(const Eigen::Ref<const Eigen::MatrixXd>& A);
[[nodiscard]] Axes right_singular(const Eigen::Ref<const Eigen::MatrixXd>& A);

}  // namespace dsp
