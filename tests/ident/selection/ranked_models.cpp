#include "ident/selection/ranked_models.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "ident/selection/best_subsets.hpp"
#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using support::gaussian;

namespace {

// Of the target's squares, by a QR of the rows themselves.
double rss_of(const MatrixXd& phi, const VectorXd& target, const std::vector<Index>& terms) {
  VectorXd left = target;
  if (!terms.empty()) {
    const MatrixXd columns = phi(Eigen::all, terms);
    left -= columns * columns.householderQr().solve(target);
  }
  return left.squaredNorm() / target.squaredNorm();
}

std::vector<Index> terms_of(unsigned set, Index num_terms) {
  std::vector<Index> terms;
  for (Index i = 0; i < num_terms; ++i)
    if ((set >> i & 1U) != 0) terms.push_back(i);
  return terms;
}

}  // namespace

TEST_CASE("all models of a library have the probabilities of their least squares", "[ident][ranked_models]") {
  constexpr Index num_rows = 150, num_terms = 6;  // fewer rows than 20 standard errors squared: one cost for both
  MatrixXd phi = gaussian(num_rows, num_terms, 1);
  phi.col(4) = phi.col(1) + 0.05 * phi.col(4);  // two that are hard to tell apart
  const VectorXd target = phi.col(0) + 0.3 * phi.col(1) + 0.2 * phi.col(3) + gaussian(num_rows, 1, 2);
  const ident::UnitProblem problem = ident::unit_problem(ident::r_factor(phi, target));
  const ident::ModelRanking found = ident::ranked_models(problem, {0});
  REQUIRE(found.all);
  REQUIRE(found.num_models == 64);

  std::vector<double> weights;
  double total = 0.0;
  VectorXd inclusion = VectorXd::Zero(num_terms);
  for (unsigned set = 0; set < 64; ++set) {
    const std::vector<Index> terms = terms_of(set, num_terms);
    weights.push_back(std::exp(-0.5 * (num_rows * std::log(rss_of(phi, target, terms)) +
                                       ident::model_cost(num_rows, num_terms, terms.size()))));
    total += weights.back();
    for (const Index term : terms) inclusion(term) += weights.back();
  }
  CHECK((found.inclusion - inclusion / total).cwiseAbs().maxCoeff() < 1e-9);
  std::sort(weights.begin(), weights.end(), std::greater<>());
  REQUIRE(found.best.size() == 10);
  for (std::size_t i = 0; i < found.best.size(); ++i) {
    CHECK(found.best[i].probability == Approx(weights[i] / total).epsilon(1e-9));
    CHECK(found.best[i].rss == Approx(rss_of(phi, target, found.best[i].terms)).epsilon(1e-12));
  }
  CHECK(found.odds() == Approx(weights[0] / weights[1]).epsilon(1e-9));
  // Which of the two it is, the rows leave open; that one of them is there, they do not.
  CHECK(found.inclusion(1) + found.inclusion(4) > 0.9);
  CHECK(found.is_undecided(1) == (found.inclusion(1) > 0.2 && found.inclusion(1) < 0.8));
}

TEST_CASE("of a wide library the models near the kept terms are scored", "[ident][ranked_models]") {
  constexpr Index num_rows = 4000, num_terms = 40;
  const MatrixXd phi = gaussian(num_rows, num_terms, 3);
  VectorXd target = gaussian(num_rows, 1, 4);
  std::vector<Index> kept;
  for (Index i = 0; i < 14; ++i) {
    kept.push_back(i);
    target += (i < 13 ? 2.0 : 0.01) * phi.col(i);  // the last of them is not worth keeping
  }
  target += 0.5 * phi.col(30);  // and one left out is
  const ident::UnitProblem problem = ident::unit_problem(ident::r_factor(phi, target));
  const ident::ModelRanking found = ident::ranked_models(problem, kept);
  CHECK_FALSE(found.all);
  CHECK(found.num_models == std::ldexp(1.0, 20));
  std::vector<Index> truth(kept.begin(), kept.end() - 1);
  truth.push_back(30);
  CHECK(found.best.front().terms == truth);
  CHECK(found.best.front().rss == Approx(rss_of(phi, target, truth)).epsilon(1e-12));
  CHECK(found.inclusion(30) > 0.99);
  CHECK(found.inclusion(0) > 0.99);
  CHECK(found.inclusion(13) < 0.5);
}

TEST_CASE("models without rows to spare are not scored, and dependent columns are no reason to stop",
          "[ident][ranked_models]") {
  MatrixXd phi = gaussian(5, 8, 5);
  phi.col(2) = phi.col(1);
  phi.col(6).setZero();
  const ident::ModelRanking found =
      ident::ranked_models(ident::unit_problem(ident::r_factor(phi, phi.col(0) + 0.1 * gaussian(5, 1, 6))), {});
  CHECK(found.num_models == 1 + 8 + 28 + 56);  // up to three terms
  CHECK(found.inclusion.allFinite());
  CHECK(found.inclusion(1) == Approx(found.inclusion(2)));
  for (const ident::RankedModel& model : found.best) CHECK(model.terms.size() <= 3);
}

TEST_CASE("an exact relation is the first of all models", "[ident][ranked_models]") {
  const MatrixXd phi = gaussian(200, 7, 7);
  const VectorXd target = 3.0 * phi.col(2) - phi.col(5);
  const ident::ModelRanking found = ident::ranked_models(ident::unit_problem(ident::r_factor(phi, target)), {2, 5});
  CHECK(found.best.front().terms == std::vector<Index>{2, 5});
  CHECK(found.inclusion(2) == Approx(1.0));
  CHECK(found.odds() > 10.0);
}

TEST_CASE("the true terms are the first model where each is above six standard errors", "[ident][ranked_models]") {
  constexpr Index num_rows = 2000, num_terms = 13;
  int right = 0;
  for (unsigned draw = 0; draw < 100; ++draw) {
    const MatrixXd phi = gaussian(num_rows, num_terms, 1000 + 2 * draw);
    // The standard error of each is 1 / sqrt(rows); seven to fourteen of them.
    const double error = 1.0 / std::sqrt(static_cast<double>(num_rows));
    VectorXd target = gaussian(num_rows, 1, 1001 + 2 * draw);
    const std::vector<Index> truth{1, 4, 6, 11};
    for (std::size_t i = 0; i < truth.size(); ++i)
      target += (8.0 + 2.0 * static_cast<double>(i)) * error * phi.col(truth[i]);
    const ident::UnitProblem problem = ident::unit_problem(ident::r_factor(phi, target));
    right += ident::ranked_models(problem, {}).best.front().terms == truth ? 1 : 0;
  }
  CHECK(right >= 95);
}
