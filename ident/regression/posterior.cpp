#include "ident/regression/posterior.hpp"

#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <numbers>

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

UnitProblem unit_problem(const RFactor& data, Index target) {
  UnitProblem unit;
  unit.num_samples = data.num_samples;
  unit.A = data.R.leftCols(data.num_terms);
  unit.y = data.R.col(data.num_terms + target);
  unit.column_norm.resize(data.num_terms);
  for (Index j = 0; j < data.num_terms; ++j) {
    unit.column_norm(j) = unit.A.col(j).stableNorm();
    if (unit.column_norm(j) > 0.0) unit.A.col(j) /= unit.column_norm(j);
  }
  unit.target_norm = unit.y.stableNorm();
  if (unit.target_norm > 0.0) unit.y /= unit.target_norm;
  return unit;
}

Posterior posterior(const UnitProblem& problem, const std::vector<Index>& kept, const VectorXd& lambda) {
  const Index b = problem.num_terms(), n = static_cast<Index>(kept.size()), rows = problem.A.rows() + n;
  Posterior at;
  at.sparsity.resize(b);
  at.quality.resize(b);

  MatrixXd augmented = MatrixXd::Zero(rows, n);
  MatrixXd others = MatrixXd::Zero(rows, b + 1);
  others.topLeftCorner(problem.A.rows(), b) = problem.A;
  others.col(b).head(problem.A.rows()) = problem.y;
  for (Index j = 0; j < n; ++j) {
    augmented.col(j).head(problem.A.rows()) = problem.A.col(kept[static_cast<std::size_t>(j)]);
    augmented(problem.A.rows() + j, j) = std::sqrt(lambda(j));
  }
  const MatrixXd kept_columns = augmented;
  if (n > 0) {
    Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> qr(augmented);
    others.applyOnTheLeft(qr.householderQ().adjoint());
    const auto T = augmented.topRows(n).triangularView<Eigen::Upper>();
    at.root = T.solve(MatrixXd::Identity(n, n));
    at.mean = T.solve(others.col(b).head(n));
    // Rows of the pseudo-inverse are the residuals of one column against the others, divided by their squared norm.
    MatrixXd Q = MatrixXd::Identity(rows, n);
    Q.applyOnTheLeft(qr.householderQ());
    const MatrixXd dual = Q * at.root.transpose();
    for (Index j = 0; j < n; ++j) {
      const Index term = kept[static_cast<std::size_t>(j)];
      const double scale = at.root.row(j).squaredNorm();
      VectorXd residual = dual.col(j) / scale;
      residual(problem.A.rows() + j) = 0.0;  // its own prior row: what is left is the column beyond the other kept ones
      at.sparsity(term) = residual.squaredNorm();
      at.quality(term) = at.mean(j) / scale;
    }
    at.log_determinant = 2.0 * augmented.diagonal().array().abs().log().sum() - lambda.array().log().sum();
  }
  const auto tail = others.col(b).tail(rows - n);
  at.misfit = tail.squaredNorm();
  VectorXd residual = problem.y;
  for (Index j = 0; j < n; ++j) residual -= kept_columns.col(j).head(problem.A.rows()) * at.mean(j);
  at.residual = residual.squaredNorm();

  std::vector<bool> is_kept(static_cast<std::size_t>(b), false);
  for (const Index term : kept) is_kept[static_cast<std::size_t>(term)] = true;
  for (Index i = 0; i < b; ++i) {
    if (is_kept[static_cast<std::size_t>(i)]) continue;
    at.sparsity(i) = others.col(i).tail(rows - n).squaredNorm();
    at.quality(i) = others.col(i).tail(rows - n).dot(tail);
  }
  return at;
}

double log_evidence(const UnitProblem& problem, const Posterior& at, double noise_variance) {
  const auto m = static_cast<double>(problem.num_samples);
  return -0.5 *
             (m * std::log(2.0 * std::numbers::pi * noise_variance) + at.log_determinant + at.misfit / noise_variance) -
         m * std::log(problem.target_norm);
}

double evidence_gain(double q) {
  return q > 1.0 ? q - 1.0 - std::log(q) : 0.0;
}

double evidence_share(double sparsity, double quality, double lambda, double noise_variance) {
  return std::log(lambda / (lambda + sparsity)) + quality * quality / noise_variance / (lambda + sparsity);
}

double best_lambda(double sparsity, double quality, double noise_variance) {
  const double excess = quality * quality / noise_variance - sparsity;
  return excess > 0.0 ? sparsity * sparsity / excess : std::numeric_limits<double>::infinity();
}

double default_tau(Index num_samples, Index num_terms) {
  return std::log(static_cast<double>(num_samples)) + 2.0 * std::log(static_cast<double>(num_terms));
}

}  // namespace ident
