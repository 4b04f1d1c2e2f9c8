#include "ident/regression/weak_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dsp/values/linear.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Models below this weight, relative to the kept terms alone, change no digit that is printed.
constexpr double negligible_weight = 1e-6;
// Of libraries wider than this, models below this weight are not told apart: so many of them are so nearly the same.
constexpr Index widest_told_apart = 60;
constexpr double told_apart_weight = 1e-3;
// Two columns closer than this to one another are rounding.
constexpr double smallest_determinant = 1e-9;

// How many weak terms are expected among those left out: one of the first degree, and of each further degree this
// fraction of the one before. Tuned on the seven systems of [QZS23], Sec. 4, which miss no weak term but one: with a
// half, 97.0 to 97.1 % of their intervals hold, with a tenth, a weak cubic left out is covered in 42 % where a half
// covers 68 %.
constexpr double fraction_per_degree = 0.25;

// Prior log odds of each of these columns: the weak terms expected of its degree, shared out evenly, none more likely
// there than not.
VectorXd prior_log_odds(const VectorXd& degree) {
  VectorXd log_odds(degree.size());
  for (Index i = 0; i < degree.size(); ++i) {
    const double expected = std::pow(fraction_per_degree, degree(i) - 1.0);
    const double probability = std::min(0.5, expected / static_cast<double>((degree.array() == degree(i)).count()));
    log_odds(i) = std::log(probability / (1.0 - probability));
  }
  return log_odds;
}

// [A_kept; sqrt(lambda)] = Q T, and the other columns seen from there.
struct LeftOutTerms {
  MatrixXd root;        // b' x b': T^-1
  VectorXd kept;        // b': coefficients of the kept terms alone
  MatrixXd products;    // of what of each column is beyond the kept ones, at unit norm
  MatrixXd replaced;    // b' x number left out: what a coefficient of 1 of it takes from the kept ones
  VectorXd projection;  // of the target on each
  VectorXd log_odds;    // prior, of each
  double rss = 0.0;     // of the target beyond the kept ones
};

LeftOutTerms left_out_of(const UnitProblem& problem, const std::vector<Index>& kept, const VectorXd& lambda) {
  const auto n = static_cast<Index>(kept.size());
  const Index rows = problem.A.rows(), b = problem.num_terms();
  MatrixXd augmented = MatrixXd::Zero(rows + n, n), others = MatrixXd::Zero(rows + n, b + 1);
  for (Index j = 0; j < n; ++j) augmented.col(j).head(rows) = problem.A.col(kept[static_cast<std::size_t>(j)]);
  augmented.bottomRows(n).diagonal() = lambda.cwiseSqrt();
  others.topLeftCorner(rows, b) = problem.A;
  others.topRightCorner(rows, 1) = problem.Y;
  const dsp::Qr qr(std::move(augmented));
  qr.rotate(others);
  const MatrixXd T = qr.triangle();

  LeftOutTerms found{
      dsp::inverse_of_upper(T), dsp::solve_upper(T, VectorXd(others.col(b).head(n))), {}, MatrixXd(n, b), {}, {}};
  MatrixXd beyond(rows, b);
  VectorXd degree(b);
  Index count = 0;
  for (Index i = 0; i < b; ++i) {
    const double norm = others.col(i).tail(rows).norm();
    // As in the search: a column within rounding of the kept ones says nothing of its own.
    if (std::find(kept.begin(), kept.end(), i) != kept.end() || !(norm * norm > smallest_sparsity(problem))) continue;
    beyond.col(count) = others.col(i).tail(rows) / norm;
    degree(count) = problem.degree.size() > 0 ? std::max(1.0, problem.degree(i)) : 1.0;
    found.replaced.col(count++) = dsp::solve_upper(T, VectorXd(others.col(i).head(n))) / norm;
  }
  const VectorXd target = others.col(b).tail(rows);
  found.products = beyond.leftCols(count).transpose() * beyond.leftCols(count);
  found.replaced.conservativeResize(n, count);
  found.projection = beyond.leftCols(count).transpose() * target;
  found.log_odds = prior_log_odds(degree.head(count));
  found.rss = target.squaredNorm();
  return found;
}

// One or two left-out terms beside the kept ones, by least squares.
struct Added {
  Index i, j;             // j < 0: one
  double c_i, c_j;        // coefficients
  double ii, ij, jj;      // of the inverse of their products
  double noise;           // variance over that without them
  double log_weight = 0;  // relative to the kept terms alone
};

Added added(const LeftOutTerms& left, Index i, Index j) {
  const double of_i = left.projection(i);
  if (j < 0) return {i, j, of_i, 0.0, 1.0, 0.0, 0.0, 1.0 - of_i * of_i / left.rss};
  const double of_j = left.projection(j), common = left.products(i, j), scale = 1.0 / (1.0 - common * common);
  Added both{i, j, scale * (of_i - common * of_j), scale * (of_j - common * of_i), scale, -scale * common, scale, 1.0};
  both.noise -= (both.c_i * of_i + both.c_j * of_j) / left.rss;
  return both;
}

// Those that are worth their weight.
std::vector<Added> models_of(const UnitProblem& problem, const LeftOutTerms& left) {
  const Index count = left.projection.size();
  std::vector<Added> models;
  const auto consider = [&](Added model, double k, double log_odds) {
    model.noise = std::max(model.noise, std::numeric_limits<double>::min());
    // Akaike's criterion: 2 ln L less two for each coefficient more.
    const double gain = -static_cast<double>(problem.num_samples) * std::log(model.noise) - 2.0 * k;
    model.log_weight = 0.5 * gain + log_odds;
    // Not a number: nothing is left to explain.
    if (model.log_weight >= std::log(negligible_weight)) models.push_back(model);
  };
  for (Index i = 0; i < count; ++i) {
    if (problem.poll) problem.poll();
    consider(added(left, i, -1), 1.0, left.log_odds(i));
    for (Index j = 0; j < i; ++j)
      if (1.0 - left.products(i, j) * left.products(i, j) >= smallest_determinant)
        consider(added(left, j, i), 2.0, left.log_odds(i) + left.log_odds(j));
  }
  return models;
}

// Normal distributions of the kept coefficients about those of the kept terms alone. The weights are relative to the
// largest: their own size may be beyond what a double holds.
class Mixture {
 public:
  // `alone`: covariance of the kept terms alone, over the noise variance without others.
  Mixture(const LeftOutTerms& left, const MatrixXd& alone, double noise_variance, const std::vector<Added>& models)
      : left_(left), alone_(alone), noise_variance_(noise_variance) {
    const Index count = left.projection.size();
    for (const Added& model : models) log_largest_ = std::max(log_largest_, model.log_weight);
    together_.moments = rest_.moments = MatrixXd::Zero(count, count);
    together_.mean = rest_.mean = VectorXd::Zero(count);
    const double weight_alone = std::exp(-log_largest_);
    add(together_, {0, -1, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0}, weight_alone);
    tell_apart(VectorXd::Zero(alone.rows()), noise_variance * alone.diagonal(), weight_alone);
    for (const Added& model : models) {
      const double weight = std::exp(model.log_weight - log_largest_);
      add(together_, model, weight);
      if (count > widest_told_apart && weight < told_apart_weight) {
        add(rest_, model, weight);
      } else {
        const auto [shift, variance] = of(model);
        tell_apart(shift, variance, weight);
      }
    }
    if (rest_.weight > 0.0) {
      const VectorXd shift = -left.replaced * rest_.mean / rest_.weight;
      tell_apart(shift, covariance(rest_).diagonal() - shift.cwiseAbs2(), rest_.weight);
    }
  }
  [[nodiscard]] MatrixXd covariance() const { return covariance(together_); }

  [[nodiscard]] double half_width_95(Index j, double variance) const {
    // Regula falsi, halving the end that stays; between 0 and sqrt(20) root mean squares by Chebyshev's inequality, and
    // nearly always as close to 1.96 of them as this.
    constexpr double wanted = 0.95, precision = 1e-7;
    const double std = std::sqrt(variance);
    const auto excess = [&](double h) { return probability_within(h, j) - wanted; };
    double low = 1.8 * std, high = 2.1 * std, below = excess(low), above = excess(high);
    if (below > 0.0) high = low, above = below, low = 0.0, below = -wanted;
    if (above < 0.0) low = high, below = above, high = std::sqrt(20.0) * std, above = excess(high);
    for (int steps = 0, side = 0; steps < 100 && high - low > precision * high && above > 0.0; ++steps) {
      const double middle = high - above * (high - low) / (above - below), at_middle = excess(middle);
      if (std::abs(at_middle) < precision) return middle;
      if (at_middle < 0.0) {
        low = middle, below = at_middle;
        if (side < 0) above *= 0.5;
        side = -1;
      } else {
        high = middle, above = at_middle;
        if (side > 0) below *= 0.5;
        side = 1;
      }
    }
    return 0.5 * (low + high);
  }

 private:
  // Sums over models, of what is added to each: weights, weighted noise, and coefficients and their products.
  struct Sums {
    double weight = 0.0, noise = 0.0;
    MatrixXd moments;
    VectorXd mean;
  };

  void add(Sums& sums, const Added& model, double weight) const {
    const double variance = model.noise * noise_variance_;
    sums.weight += weight;
    sums.noise += weight * variance;
    if (sums.mean.size() == 0) return;
    sums.mean(model.i) += weight * model.c_i;
    sums.moments(model.i, model.i) += weight * (variance * model.ii + model.c_i * model.c_i);
    if (model.j < 0) return;
    sums.mean(model.j) += weight * model.c_j;
    sums.moments(model.j, model.j) += weight * (variance * model.jj + model.c_j * model.c_j);
    const double common = weight * (variance * model.ij + model.c_i * model.c_j);
    sums.moments(model.i, model.j) += common;
    sums.moments(model.j, model.i) += common;
  }
  // About the kept terms alone.
  [[nodiscard]] MatrixXd covariance(const Sums& sums) const {
    return (sums.noise * alone_ + left_.replaced * sums.moments * left_.replaced.transpose()) / sums.weight;
  }
  // Shift and variances of the kept coefficients.
  [[nodiscard]] std::pair<VectorXd, VectorXd> of(const Added& model) const {
    VectorXd shift = -model.c_i * left_.replaced.col(model.i),
             variance = alone_.diagonal() + model.ii * left_.replaced.col(model.i).cwiseAbs2();
    if (model.j >= 0) {
      const auto r_i = left_.replaced.col(model.i), r_j = left_.replaced.col(model.j);
      shift -= model.c_j * r_j;
      variance += 2.0 * model.ij * r_i.cwiseProduct(r_j) + model.jj * r_j.cwiseAbs2();
    }
    return {shift, model.noise * noise_variance_ * variance};
  }
  void tell_apart(VectorXd shift, VectorXd variance, double weight) {
    weights_.push_back(weight);
    shifts_.push_back(std::move(shift));
    variances_.push_back(std::move(variance));
  }
  // Of the interval +-h about zero, for coefficient j.
  [[nodiscard]] double probability_within(double h, Index j) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < weights_.size(); ++k) {
      const double unit = std::sqrt(2.0 * variances_[k](j)), shift = shifts_[k](j);
      sum += weights_[k] * 0.5 * (std::erf((h - shift) / unit) + std::erf((h + shift) / unit));
    }
    return sum / together_.weight;
  }

  const LeftOutTerms& left_;
  const MatrixXd& alone_;
  double noise_variance_, log_largest_ = 0.0;
  Sums together_, rest_;
  std::vector<double> weights_;
  std::vector<VectorXd> shifts_, variances_;
};

// What kept terms that may be none add: one at zero moves the others by its part of the target. `alone`: covariance by
// noise, over the noise variance.
MatrixXd moments_of_terms_at_zero(const LeftOutTerms& left, const MatrixXd& alone, double noise_variance, double tau) {
  MatrixXd sum = MatrixXd::Zero(alone.rows(), alone.cols());
  for (Index j = 0; j < left.kept.size(); ++j) {
    const double c2 = left.kept(j) * left.kept(j);
    const double probability = probability_of(evidence_gain(c2 / (noise_variance * alone(j, j))), tau);
    if (!(probability < 1.0)) continue;  // not a number: no noise
    const VectorXd part = alone.col(j) / alone(j, j);
    sum += (1.0 - probability) * c2 * part * part.transpose();
  }
  return sum;
}

}  // namespace

MatrixXd covariance_with_weak_terms(const UnitProblem& problem, const std::vector<Index>& kept, const VectorXd& lambda,
                                    double noise_variance, double tau) {
  const LeftOutTerms left = left_out_of(problem, kept, lambda);
  const MatrixXd alone = left.root * left.root.transpose();
  const Mixture mixture(left, alone, noise_variance, models_of(problem, left));
  const MatrixXd covariance = mixture.covariance();
  VectorXd scale(covariance.rows());
  for (Index j = 0; j < scale.size(); ++j)
    scale(j) = mixture.half_width_95(j, covariance(j, j)) / (1.959964 * std::sqrt(covariance(j, j)));
  return scale.asDiagonal() * covariance * scale.asDiagonal() +
         moments_of_terms_at_zero(left, alone, noise_variance, tau);
}

}  // namespace ident
