#include "ident/regression/posterior.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "dsp/values/linear.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Divides each column by its norm and returns the norms.
VectorXd normalise(MatrixXd& columns) {
  VectorXd norm(columns.cols());
  for (Index j = 0; j < columns.cols(); ++j) {
    norm(j) = columns.col(j).stableNorm();
    if (norm(j) > 0.0) columns.col(j) /= norm(j);
  }
  return norm;
}

// M'M, summed as squaredNorm does.
MatrixXd gram(const Eigen::Ref<const MatrixXd>& columns) {
  MatrixXd products(columns.cols(), columns.cols());
  for (Index j = 0; j < columns.cols(); ++j)
    for (Index k = 0; k < columns.cols(); ++k) products(j, k) = columns.col(j).dot(columns.col(k));
  return products;
}

std::vector<Index> all_but(const std::vector<Index>& kept, Index num_terms) {
  std::vector<bool> is_kept(static_cast<std::size_t>(num_terms), false);
  for (const Index term : kept) is_kept[static_cast<std::size_t>(term)] = true;
  std::vector<Index> others;
  for (Index i = 0; i < num_terms; ++i)
    if (!is_kept[static_cast<std::size_t>(i)]) others.push_back(i);
  return others;
}

}  // namespace

double smallest_sparsity(const UnitProblem& problem) {
  return std::pow(4.0 * std::numeric_limits<double>::epsilon(), 2) * static_cast<double>(problem.A.rows());
}

UnitProblem unit_problem(const RFactor& data, Poll poll) {
  UnitProblem unit;
  unit.poll = std::move(poll);
  unit.num_samples = data.num_samples;
  unit.degree = data.degree;
  unit.A = data.R.leftCols(data.num_terms);
  unit.Y = data.R.rightCols(data.num_targets());
  unit.column_norm = normalise(unit.A);
  unit.target_norm = normalise(unit.Y);
  return unit;
}

Posterior posterior(const UnitProblem& problem, const std::vector<Index>& kept, const VectorXd& lambda) {
  if (problem.poll) problem.poll();
  const Index b = problem.num_terms(), q = problem.num_targets(), n = static_cast<Index>(kept.size()),
              data_rows = problem.A.rows(), rows = data_rows + n;
  Posterior at;
  at.mean.resize(n, q);
  at.sparsity.resize(b);
  at.quality.resize(b, q);

  MatrixXd augmented = MatrixXd::Zero(rows, n);
  const std::vector<Index> left_out = all_but(kept, b);
  const auto num_left_out = static_cast<Index>(left_out.size());
  // The left-out columns, then the targets; at least two, since one alone would be rotated by another kernel, and the
  // last bits of a target's figures would depend on whether a term is left out.
  MatrixXd others = MatrixXd::Zero(rows, std::max<Index>(2, num_left_out + q));
  for (Index j = 0; j < num_left_out; ++j)
    others.col(j).head(data_rows) = problem.A.col(left_out[static_cast<std::size_t>(j)]);
  others.block(0, num_left_out, data_rows, q) = problem.Y;
  for (Index j = 0; j < n; ++j) {
    augmented.col(j).head(data_rows) = problem.A.col(kept[static_cast<std::size_t>(j)]);
    augmented(data_rows + j, j) = std::sqrt(lambda(j));
  }
  if (n > 0) {
    const dsp::Qr qr(std::move(augmented));
    qr.rotate(others);
    const MatrixXd T = qr.triangle();
    at.root = dsp::inverse_of_upper(T);
    for (Index t = 0; t < q; ++t) at.mean.col(t) = dsp::solve_upper(T, VectorXd(others.col(num_left_out + t).head(n)));
    // Rows of the pseudo-inverse are the residuals of one column against the others, divided by their squared norm.
    const MatrixXd dual = qr.basis() * at.root.transpose();
    for (Index j = 0; j < n; ++j) {
      const Index term = kept[static_cast<std::size_t>(j)];
      const double scale = at.root.row(j).squaredNorm();
      VectorXd residual = dual.col(j) / scale;
      residual(data_rows + j) = 0.0;  // its own prior row: what is left is the column beyond the other kept ones
      at.sparsity(term) = residual.squaredNorm();
      at.quality.row(term) = at.mean.row(j) / scale;
    }
    at.log_determinant = 2.0 * T.diagonal().array().abs().log().sum() - lambda.array().log().sum();
  }
  const auto tail = others.block(n, num_left_out, rows - n, q);
  at.misfit = gram(tail);
  MatrixXd residual = problem.Y;
  for (Index t = 0; t < q; ++t)
    for (Index j = 0; j < n; ++j) residual.col(t) -= problem.A.col(kept[static_cast<std::size_t>(j)]) * at.mean(j, t);
  at.residual = gram(residual);

  for (Index j = 0; j < num_left_out; ++j) {
    const Index term = left_out[static_cast<std::size_t>(j)];
    const auto beyond = others.col(j).tail(rows - n);
    at.sparsity(term) = beyond.squaredNorm();
    for (Index t = 0; t < q; ++t) at.quality(term, t) = beyond.dot(tail.col(t));
  }
  return at;
}

NoiseCovariance NoiseCovariance::of(const MatrixXd& products, double count, double floor) {
  if (products.size() == 1) return {MatrixXd::Ones(1, 1), (products.diagonal() / count).cwiseMax(floor)};
  const dsp::Axes eigen = dsp::eigen_symmetric(products / count);
  const double least = std::max(floor, 1e-14 * eigen.values.maxCoeff());
  return {eigen.vectors, eigen.values.cwiseMax(least)};
}

double log_evidence(const UnitProblem& problem, const Posterior& at, const NoiseCovariance& noise) {
  const auto m = static_cast<double>(problem.num_samples);
  double log_noise = 0.0, misfit = 0.0, log_norm = 0.0;
  for (Index t = 0; t < problem.num_targets(); ++t) {
    log_noise += std::log(2.0 * std::numbers::pi * noise.variances(t));
    misfit += noise.axes.col(t).dot(at.misfit.lazyProduct(noise.axes.col(t))) / noise.variances(t);
    log_norm += std::log(problem.target_norm(t));
  }
  return -0.5 * (m * log_noise + static_cast<double>(problem.num_targets()) * at.log_determinant + misfit) -
         m * log_norm;
}

double log_evidence(const UnitProblem& problem, const Posterior& at, double noise_variance) {
  return log_evidence(problem, at, {MatrixXd::Ones(1, 1), VectorXd::Constant(1, noise_variance)});
}

double evidence_gain(double q) {
  return q > 1.0 ? q - 1.0 - std::log(q) : 0.0;
}

double probability_of(double gain, double tau) {
  return 1.0 / (1.0 + std::exp(0.5 * (tau - gain)));
}

double evidence_contribution(double sparsity, double quality2, double lambda) {
  return std::log(lambda / (lambda + sparsity)) + quality2 / (lambda + sparsity);
}

double best_lambda(double sparsity, double quality2) {
  const double excess = quality2 - sparsity;
  return excess > 0.0 ? sparsity * sparsity / excess : std::numeric_limits<double>::infinity();
}

double gain_threshold(Selection selection, double tau, Index num_samples, Index num_terms) {
  if (tau >= 0.0) return tau;
  if (selection == Selection::type2) return 0.0;
  return std::log(static_cast<double>(num_samples)) + 2.0 * std::log(static_cast<double>(num_terms));
}

}  // namespace ident
