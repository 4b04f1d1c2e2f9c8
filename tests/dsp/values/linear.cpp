#include "dsp/values/linear.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "support/signals.hpp"

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(Index rows, Index cols, unsigned seed) {
  return support::gaussian(rows * cols, seed).reshaped(rows, cols);
}

// Rounding of sums of up to a hundred products of about 1, in matrices of condition numbers below a hundred.
constexpr double rounding = 1e-11;

double distance(const MatrixXd& a, const MatrixXd& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

}  // namespace

// The widths lie on both sides of the block of columns that reflections are gathered in.
TEST_CASE("a QR gives back its matrix, and turns without stretching", "[dsp][linear]") {
  for (const Index n : {1, 4, 60}) {
    const MatrixXd A = random_matrix(n + 30, n, 1), B = random_matrix(n + 30, 3, 2);
    const dsp::Qr qr(A);
    const MatrixXd R = qr.triangle(), Q = qr.basis();
    CHECK(distance(Q * R, A) < rounding);
    CHECK(distance(Q.transpose() * Q, MatrixXd::Identity(n, n)) < rounding);
    CHECK(R.isUpperTriangular(0.0));
    MatrixXd turned = B, itself = A;
    qr.rotate(turned);
    qr.rotate(itself);
    CHECK(distance(turned.transpose() * turned, B.transpose() * B) < rounding);
    CHECK(distance(turned.topRows(n), Q.transpose() * B) < rounding);
    CHECK(distance(itself.topRows(n), R) < rounding);
    CHECK(itself.bottomRows(30).cwiseAbs().maxCoeff() < rounding);
  }
}

TEST_CASE("triangles are solved for from above their diagonal alone", "[dsp][linear]") {
  const Index n = 20;
  MatrixXd R = random_matrix(n, n, 3) / 10.0;
  R.diagonal().setConstant(1.0);
  const MatrixXd B = random_matrix(n, 5, 4), upper = R.triangularView<Eigen::Upper>();
  const VectorXd b = B.col(0);
  CHECK(distance(upper * dsp::solve_upper(R, B), B) < rounding);
  CHECK(distance(upper * dsp::solve_upper(R, b), b) < rounding);
  CHECK(distance(upper.transpose() * dsp::solve_transposed(R, B), B) < rounding);
  CHECK(distance(upper.transpose() * dsp::solve_transposed(R, b), b) < rounding);
  CHECK(distance(upper * dsp::inverse_of_upper(R), MatrixXd::Identity(n, n)) < rounding);
}

TEST_CASE("least squares leave what no column has a part of, by the shortest vector", "[dsp][linear]") {
  MatrixXd A = random_matrix(40, 6, 5);
  const VectorXd b = random_matrix(40, 1, 6);
  CHECK((A.transpose() * (b - A * dsp::least_squares(A, b))).cwiseAbs().maxCoeff() < rounding);
  A.col(5) = A.col(0);
  const VectorXd x = dsp::least_squares(A, b);
  CHECK((A.transpose() * (b - A * x)).cwiseAbs().maxCoeff() < rounding);
  CHECK(x(5) == Approx(x(0)));  // of all ways to share out what two equal columns hold, halves are shortest
  const MatrixXd wide = A.transpose();
  const VectorXd right = wide * VectorXd::Ones(40), y = dsp::least_squares(wide, right);
  CHECK(distance(wide * y, right) < rounding);
  CHECK(y.norm() <= std::sqrt(40.0));
}

TEST_CASE("a symmetric matrix is solved for, inverted and taken to its axes", "[dsp][linear]") {
  const MatrixXd root = random_matrix(30, 12, 7), A = root.transpose() * root;
  const VectorXd b = random_matrix(12, 1, 8);
  CHECK(distance(A * dsp::solve_symmetric(A, b), b) < rounding);
  CHECK(distance(A * dsp::inverse_of_symmetric(A), MatrixXd::Identity(12, 12)) < rounding);
  const dsp::Axes axes = dsp::eigen_symmetric(A);
  CHECK(std::is_sorted(axes.values.begin(), axes.values.end()));
  CHECK(distance(axes.vectors * axes.values.asDiagonal() * axes.vectors.transpose(), A) < rounding);
  CHECK(distance(axes.vectors.transpose() * axes.vectors, MatrixXd::Identity(12, 12)) < rounding);
  const Eigen::Matrix2d two = A.topLeftCorner(2, 2), twice = two * dsp::inverse_of(two);
  CHECK(distance(twice, MatrixXd::Identity(2, 2)) < rounding);
}

// A = U S V': A'A has the axes V, AA' the axes U, and the squares of the singular values.
TEST_CASE("singular values and vectors are those of the squares", "[dsp][linear]") {
  const Index n = 15;
  const MatrixXd A = random_matrix(n, n, 9);
  const auto [s, U] = dsp::left_singular(A);
  const auto [values, V] = dsp::right_singular(A);
  CHECK(std::is_sorted(s.begin(), s.end(), std::greater<>()));
  CHECK(distance(s, values) == 0.0);
  CHECK(distance(s, dsp::singular_values(A)) == 0.0);
  CHECK(distance(A * A.transpose() * U, U * s.cwiseAbs2().asDiagonal()) < rounding);
  CHECK(distance(A.transpose() * A * V, V * s.cwiseAbs2().asDiagonal()) < rounding);
  CHECK(s.squaredNorm() == Approx(A.squaredNorm()));
}
