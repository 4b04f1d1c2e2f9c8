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
  MatrixXd beyond;      // what of each column is beyond the kept ones, at unit norm
  MatrixXd replaced;    // b' x number left out: what a coefficient of 1 of it takes from the kept ones
  VectorXd target;      // the target beyond the kept ones
  VectorXd projection;  // of the target on each column
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

  LeftOut found{
      T.solve(MatrixXd::Identity(n, n)), MatrixXd(rows, b), MatrixXd(n, b), others.bottomRightCorner(rows, 1), {}};
  Index count = 0;
  for (Index i = 0; i < b; ++i) {
    const double norm = others.col(i).tail(rows).norm();
    // As in the search: a column within rounding of the kept ones says nothing of its own.
    if (std::find(kept.begin(), kept.end(), i) != kept.end() ||
        !(norm > 4.0 * std::numeric_limits<double>::epsilon() * std::sqrt(static_cast<double>(rows))))
      continue;
    found.beyond.col(count) = others.col(i).tail(rows) / norm;
    found.replaced.col(count++) = T.solve(others.col(i).head(n)) / norm;
  }
  found.beyond.conservativeResize(rows, count);
  found.replaced.conservativeResize(n, count);
  found.projection = found.beyond.transpose() * found.target;
  return found;
}

// Normal distributions of the kept coefficients about those of the kept terms alone.
struct Mixture {
  double total_weight = 0.0;
  MatrixXd covariance;  // times total_weight
  std::vector<double> weights;
  std::vector<VectorXd> shifts, variances;

  void add(double weight, const VectorXd& shift, const MatrixXd& its_covariance) {
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
  Mixture mixture{0.0, MatrixXd::Zero(n, n), {}, {}, {}};
  mixture.add(1.0, VectorXd::Zero(n), noise_variance * alone);

  const double rss = left.target.squaredNorm(), odds = 1.0 / std::max(1.0, static_cast<double>(count) - 1.0);
  const auto with = [&](const std::vector<Index>& added) {
    const MatrixXd columns = left.beyond(Eigen::all, added), replaced = left.replaced(Eigen::all, added);
    const MatrixXd products = columns.transpose() * columns;
    if (products.determinant() < smallest_determinant) return;
    const MatrixXd inverse = products.inverse();
    const VectorXd coefficients = inverse * left.projection(added);
    const double noise =
        std::max(1.0 - coefficients.dot(left.projection(added)) / rss, std::numeric_limits<double>::min());
    // Akaike's criterion: 2 ln L less two for each coefficient more.
    const double gain =
        -static_cast<double>(problem.num_samples) * std::log(noise) - 2.0 * static_cast<double>(added.size());
    const double weight = std::exp(0.5 * gain) * std::pow(odds, static_cast<double>(added.size()));
    if (weight < negligible_weight) return;
    mixture.add(weight, -replaced * coefficients,
                noise * noise_variance * (alone + replaced * inverse * replaced.transpose()));
  };
  for (Index i = 0; i < count; ++i) {
    with({i});
    for (Index j = 0; j < i; ++j) with({j, i});
  }

  const MatrixXd covariance = mixture.covariance / mixture.total_weight;
  VectorXd scale(n);
  for (Index j = 0; j < n; ++j) scale(j) = mixture.half_width_95(j) / (1.959964 * std::sqrt(covariance(j, j)));
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

}  // namespace ident
