#include "dsp/values/linear.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cassert>
#include <utility>

namespace dsp {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Matrix = Eigen::Ref<const MatrixXd>;

namespace {

using SquareSvd = Eigen::JacobiSVD<MatrixXd, Eigen::NoQRPreconditioner>;

SquareSvd square_svd(const Matrix& A, unsigned options) {
  assert(A.rows() == A.cols());
  return SquareSvd(A, options);
}

}  // namespace

Qr::Qr(MatrixXd A) : reflections_(std::move(A)) {
  assert(reflections_.rows() >= reflections_.cols());
  factors_ = Eigen::HouseholderQR<Eigen::Ref<MatrixXd>>(reflections_).hCoeffs();
}

MatrixXd Qr::triangle() const {
  return reflections_.topRows(reflections_.cols()).triangularView<Eigen::Upper>();
}

MatrixXd Qr::basis() const {
  MatrixXd Q = MatrixXd::Identity(reflections_.rows(), reflections_.cols());
  Q.applyOnTheLeft(Eigen::householderSequence(reflections_, factors_));
  return Q;
}

void Qr::rotate(Eigen::Ref<MatrixXd> B) const {
  B.applyOnTheLeft(Eigen::householderSequence(reflections_, factors_).adjoint());
}

VectorXd solve_upper(const Matrix& R, const VectorXd& b) {
  return R.triangularView<Eigen::Upper>().solve(b);
}

MatrixXd solve_upper(const Matrix& R, const MatrixXd& B) {
  return R.triangularView<Eigen::Upper>().solve(B);
}

VectorXd solve_transposed(const Matrix& R, const VectorXd& b) {
  return R.triangularView<Eigen::Upper>().transpose().solve(b);
}

MatrixXd solve_transposed(const Matrix& R, const MatrixXd& B) {
  return R.triangularView<Eigen::Upper>().transpose().solve(B);
}

MatrixXd inverse_of_upper(const Matrix& R) {
  return solve_upper(R, MatrixXd(MatrixXd::Identity(R.rows(), R.cols())));
}

VectorXd least_squares(const Matrix& A, const VectorXd& b) {
  return Eigen::CompleteOrthogonalDecomposition<MatrixXd>(A).solve(b);
}

VectorXd solve_symmetric(const Matrix& A, const VectorXd& b) {
  return Eigen::LDLT<MatrixXd>(A).solve(b);
}

MatrixXd inverse_of_symmetric(const Matrix& A) {
  return Eigen::LDLT<MatrixXd>(A).solve(MatrixXd::Identity(A.rows(), A.cols()));
}

Eigen::Matrix2d inverse_of(const Eigen::Matrix2d& A) {
  return A.inverse();
}

Axes eigen_symmetric(const Matrix& A) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd singular_values(const Matrix& A) {
  return square_svd(A, 0).singularValues();
}

Axes left_singular(const Matrix& A) {
  const SquareSvd svd = square_svd(A, Eigen::ComputeFullU);
  return {svd.singularValues(), svd.matrixU()};
}

Axes right_singular(const Matrix& A) {
  const SquareSvd svd = square_svd(A, Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixV()};
}

}  // namespace dsp
