#include "ident/regression/weak_terms.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Models below this weight, relative to the kept terms alone, change no digit that is printed.
constexpr double negligible_weight = 1e-6;
// Two columns closer than this to one another are rounding.
constexpr double smallest_determinant = 1e-9;

// [A_kept; sqrt(lambda)] = Q T, and the other columns seen from there.
struct LeftOut {
  MatrixXd root;        // b' x b': T^-1
  MatrixXd products;    // of what of each column is beyond the kept ones, at unit norm
  MatrixXd replaced;    // b' x number left out: what a coefficient of 1 of it takes from the kept ones
  VectorXd projection;  // of the target on each
  double rss = 0.0;     // of the target beyond the kept ones
};

LeftOut left_out_of(const UnitProblem& problem, const std::vector<Index>& kept, const VectorXd& lambda) {
  const auto n = static_cast<Index>(kept.size());
  const Index rows = problem.A.rows(), b = problem.num_terms();
  MatrixXd augmented = MatrixXd::Zero(rows + n, n), others = MatrixXd::Zero(rows + n, b + 1);
  for (Index j = 0; j < n; ++j) augmented.col(j).head(rows) = problem.A.col(kept[static_cast<std::size_t>(j)]);
  augmented.bottomRows(n).diagonal() = lambda.cwiseSqrt();
  others.topLeftCorner(rows, b) = problem.A;
  others.topRightCorner(rows, 1) = problem.Y;
  const Eigen::HouseholderQR<MatrixXd> qr(augmented);
  others.applyOnTheLeft(qr.householderQ().adjoint());
  const auto T = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();

  LeftOut found{T.solve(MatrixXd::Identity(n, n)), {}, MatrixXd(n, b), {}};
  MatrixXd beyond(rows, b);
  Index count = 0;
  for (Index i = 0; i < b; ++i) {
    const double norm = others.col(i).tail(rows).norm();
    // As in the search: a column within rounding of the kept ones says nothing of its own.
    if (std::find(kept.begin(), kept.end(), i) != kept.end() || !(norm * norm > smallest_sparsity(problem))) continue;
    beyond.col(count) = others.col(i).tail(rows) / norm;
    found.replaced.col(count++) = T.solve(others.col(i).head(n)) / norm;
  }
  const VectorXd target = others.col(b).tail(rows);
  found.products = beyond.leftCols(count).transpose() * beyond.leftCols(count);
  found.replaced.conservativeResize(n, count);
  found.projection = beyond.leftCols(count).transpose() * target;
  found.rss = target.squaredNorm();
  return found;
}

// Normal distributions of the kept coefficients about those of the kept terms alone. Weights are relative to the
// largest so far: their own size may be beyond what a double holds.
struct Mixture {
  double log_largest = 0.0, total_weight = 0.0;
  MatrixXd covariance;  // times total_weight
  std::vector<double> weights;
  std::vector<VectorXd> shifts, variances;

  void add(double log_weight, const VectorXd& shift, const MatrixXd& its_covariance) {
    if (log_weight > log_largest) {
      const double smaller = std::exp(log_largest - log_weight);
      total_weight *= smaller;
      covariance *= smaller;
      for (double& weight : weights) weight *= smaller;
      log_largest = log_weight;
    }
    const double weight = std::exp(log_weight - log_largest);
    total_weight += weight;
    covariance += weight * (its_covariance + shift * shift.transpose());
    weights.push_back(weight);
    shifts.push_back(shift);
    variances.push_back(its_covariance.diagonal());
  }

  // Of the interval +-h about zero, for coefficient j.
  [[nodiscard]] double probability_within(double h, Index j) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      const double unit = std::sqrt(2.0 * variances[k](j)), shift = shifts[k](j);
      sum += weights[k] * 0.5 * (std::erf((h - shift) / unit) + std::erf((h + shift) / unit));
    }
    return sum / total_weight;
  }

  [[nodiscard]] double half_width_95(Index j) const {
    // By Chebyshev's inequality 95 % are within sqrt(20) root mean squares. 30 halvings: nine digits.
    double low = 0.0, high = std::sqrt(20.0 * covariance(j, j) / total_weight);
    for (int halving = 0; halving < 30; ++halving) {
      const double middle = 0.5 * (low + high);
      (probability_within(middle, j) < 0.95 ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }
};

}  // namespace

MatrixXd covariance_with_weak_terms(const UnitProblem& problem, const std::vector<Index>& kept, const VectorXd& lambda,
                                    double noise_variance) {
  const LeftOut left = left_out_of(problem, kept, lambda);
  const Index n = left.root.rows(), count = left.projection.size();
  const MatrixXd alone = left.root * left.root.transpose();
  Mixture mixture{.covariance = MatrixXd::Zero(n, n)};
  mixture.add(0.0, VectorXd::Zero(n), noise_variance * alone);

  const double log_odds = -std::log(std::max(1.0, static_cast<double>(count) - 1.0));
  const auto with = [&](const std::vector<Index>& added) {
    const MatrixXd products = left.products(added, added), replaced = left.replaced(Eigen::all, added);
    if (products.determinant() < smallest_determinant) return;
    const MatrixXd inverse = products.inverse();
    const VectorXd coefficients = inverse * left.projection(added);
    const double noise =
        std::max(1.0 - coefficients.dot(left.projection(added)) / left.rss, std::numeric_limits<double>::min());
    // Akaike's criterion: 2 ln L less two for each coefficient more.
    const auto k = static_cast<double>(added.size());
    const double gain = -static_cast<double>(problem.num_samples) * std::log(noise) - 2.0 * k;
    const double log_weight = 0.5 * gain + k * log_odds;
    if (!(log_weight >= std::log(negligible_weight))) return;  // not a number: nothing is left to explain
    mixture.add(log_weight, -replaced * coefficients,
                noise * noise_variance * (alone + replaced * inverse * replaced.transpose()));
  };
  for (Index i = 0; i < count; ++i) {
    if (problem.poll) problem.poll();
    with({i});
    for (Index j = 0; j < i; ++j) with({j, i});
  }

  const MatrixXd covariance = mixture.covariance / mixture.total_weight;
  VectorXd scale(n);
  for (Index j = 0; j < n; ++j) scale(j) = mixture.half_width_95(j) / (1.959964 * std::sqrt(covariance(j, j)));
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

}  // namespace ident
