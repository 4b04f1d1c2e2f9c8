#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "ident/regression/fit.hpp"
#include "ident/regression/posterior.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Support = std::vector<Index>;

namespace {

constexpr double nothing = -std::numeric_limits<double>::infinity();

// 2 log evidence - tau x terms at the best alphas and noise of a support, by plain fixed-point iteration; nothing where
// a term of it has no finite best alpha.
double best_criterion(const ident::UnitProblem& unit, const Support& kept, double tau) {
  const auto m = static_cast<double>(unit.num_samples);
  VectorXd lambda = VectorXd::Constant(static_cast<Index>(kept.size()), 1e-6);
  ident::Posterior at = ident::posterior(unit, kept, lambda);
  for (int i = 0; i < 2000; ++i) {
    const double noise = at.misfit(0, 0) / m;
    double change = 0.0;
    for (std::size_t j = 0; j < kept.size(); ++j) {
      const double best = ident::best_lambda(at.sparsity(kept[j]), std::pow(at.quality(kept[j]), 2) / noise);
      if (!std::isfinite(best)) return nothing;
      double& old = lambda(static_cast<Index>(j));
      change = std::max(change, std::abs(std::log(best / old)));
      old = best;
    }
    at = ident::posterior(unit, kept, lambda);
    if (change < 1e-7) break;
  }
  return 2.0 * ident::log_evidence(unit, at, at.misfit(0, 0) / m) - tau * static_cast<double>(kept.size());
}

// What no prior can beat: the likelihood at least squares, without the price of the terms' determinant.
double upper_bound(const ident::UnitProblem& unit, const Support& kept, double tau) {
  const auto m = static_cast<double>(unit.num_samples);
  const auto at = ident::posterior(unit, kept, VectorXd::Constant(static_cast<Index>(kept.size()), 1e-14));
  return -m * (std::log(2.0 * std::numbers::pi * at.residual(0, 0) / m) + 1.0) -
         2.0 * m * std::log(unit.target_norm(0)) - tau * static_cast<double>(kept.size());
}

struct Subset {
  Support kept;
  double criterion = nothing;
};

Subset best_of_all_subsets(const ident::UnitProblem& unit, double tau, Subset best) {
  for (unsigned subset = 0; subset < 1u << unit.num_terms(); ++subset) {
    Support kept;
    for (Index i = 0; i < unit.num_terms(); ++i)
      if (subset >> i & 1u) kept.push_back(i);
    if (upper_bound(unit, kept, tau) <= best.criterion) continue;
    const double criterion = best_criterion(unit, kept, tau);
    if (criterion > best.criterion) best = {std::move(kept), criterion};
  }
  return best;
}

struct Problem {
  MatrixXd phi;
  VectorXd target;
};

// Libraries of several kinds: independent columns, columns with a common part, powers of one signal, powers of an
// offset signal; 1 to 3 true terms from barely visible to plain; 40 to 400 rows.
Problem random_problem(unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  const auto pick = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine); };
  const int kind = pick(0, 3);
  const Index terms = pick(3, 10), rows = pick(40, 400);
  Problem p{MatrixXd::NullaryExpr(rows, terms, [&] { return normal(engine); }), VectorXd::Zero(rows)};
  if (kind == 1) p.phi.rightCols(terms - 1) += std::exp(normal(engine)) * p.phi.col(0).replicate(1, terms - 1);
  if (kind >= 2) {
    VectorXd signal = p.phi.col(0);
    if (kind == 3) signal.array() += 3.0;
    for (Index j = 0; j < terms; ++j) p.phi.col(j) = signal.array().pow(static_cast<double>(j));
  }
  for (int count = pick(1, 3); count > 0; --count) {
    const Index term = pick(0, static_cast<int>(terms) - 1);
    p.target += std::exp(normal(engine)) * normal(engine) * p.phi.col(term) / p.phi.col(term).norm() *
                std::sqrt(static_cast<double>(rows));
  }
  p.target += std::exp(-1.5 * std::abs(normal(engine))) * VectorXd::NullaryExpr(rows, [&] { return normal(engine); });
  return p;
}

}  // namespace

TEST_CASE("the search ends at the best of all subsets in nearly all of a thousand random problems",
          "[ident][fast_rvm]") {
  // The rule tests each term at the noise of the end; the criterion re-estimates the noise for every subset. With few
  // rows the two disagree about a term whose gain is close to tau: one term more or less. What differs in several
  // terms is an end of the search that no single change improves.
  int borderline = 0, stuck = 0;
  double most = 0.0;
  for (unsigned seed = 0; seed < 1000; ++seed) {
    const Problem p = random_problem(seed);
    const auto data = ident::r_factor(p.phi, p.target);
    const auto fit = ident::fit_fast_rvm(data);
    REQUIRE(fit.status != ident::FitStatus::iteration_limit);
    const double ours = 2.0 * fit.log_evidence - fit.tau * static_cast<double>(fit.relevant.size());
    const auto best = best_of_all_subsets(ident::unit_problem(data), fit.tau, {fit.relevant, ours});
    if (best.criterion <= ours + 1e-4) continue;
    most = std::max(most, best.criterion - ours);
    Support changed;
    std::set_symmetric_difference(fit.relevant.begin(), fit.relevant.end(), best.kept.begin(), best.kept.end(),
                                  std::back_inserter(changed));
    ++(changed.size() == 1 ? borderline : stuck);
  }
  INFO("borderline " << borderline << ", stuck " << stuck << ", by " << most << " at most");
  CHECK(borderline <= 5);
  CHECK(stuck <= 5);
  CHECK(most <= 3.0);  // of 2 log evidence: odds of four to one
}
