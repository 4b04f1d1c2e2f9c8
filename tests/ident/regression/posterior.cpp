#include "ident/regression/posterior.hpp"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "support/random.hpp"

namespace test_regression_posterior {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using support::gaussian;

namespace {

struct Problem {
  MatrixXd phi;
  VectorXd target;
  ident::UnitProblem unit;
};

Problem make_problem(Index rows, Index terms, unsigned seed) {
  Problem p{gaussian(rows, terms, seed), {}, {}};
  p.phi.col(1) += 3.0 * p.phi.col(0);  // some collinearity
  p.target = p.phi.col(0) * 2.0 + 0.3 * p.phi.col(1) - p.phi.col(2) + 0.5 * gaussian(rows, 1, seed + 1);
  p.unit = ident::unit_problem(ident::r_factor(p.phi, p.target));
  return p;
}

// Eq. 15 of [QZS23] as printed: Cholesky of the m x m matrix Omega.
double evidence_by_rows(const Problem& p, const std::vector<Index>& kept, const VectorXd& alpha,
                        double noise_variance) {
  const Index m = p.phi.rows();
  MatrixXd omega = MatrixXd::Identity(m, m) * noise_variance;
  for (std::size_t j = 0; j < kept.size(); ++j)
    omega += p.phi.col(kept[j]) * p.phi.col(kept[j]).transpose() / alpha(static_cast<Index>(j));
  const Eigen::LLT<MatrixXd> llt(omega);
  const MatrixXd L = llt.matrixL();
  return -0.5 * (static_cast<double>(m) * std::log(2.0 * std::numbers::pi) + 2.0 * L.diagonal().array().log().sum() +
                 p.target.dot(llt.solve(p.target)));
}

VectorXd lambda_of(const Problem& p, const std::vector<Index>& kept, const VectorXd& alpha, double noise_variance) {
  VectorXd lambda(alpha.size());
  for (std::size_t j = 0; j < kept.size(); ++j)
    lambda(static_cast<Index>(j)) =
        alpha(static_cast<Index>(j)) * noise_variance / std::pow(p.unit.column_norm(kept[j]), 2);
  return lambda;
}

}  // namespace

TEST_CASE("the evidence from R equals the Cholesky of the m x m covariance", "[ident][posterior]") {
  const Problem p = make_problem(300, 6, 20);
  const std::vector<Index> kept{0, 2, 4};
  const VectorXd alpha = VectorXd{{0.3, 2.0, 40.0}};
  const double noise = 0.25, unit_noise = noise / std::pow(p.unit.target_norm(0), 2);
  const auto at = ident::posterior(p.unit, kept, lambda_of(p, kept, alpha, noise));
  const double expected = evidence_by_rows(p, kept, alpha, noise);
  CHECK(ident::log_evidence(p.unit, at, unit_noise) == Approx(expected).epsilon(1e-10));
}

TEST_CASE("each promised gain equals the difference of two evidences", "[ident][posterior]") {
  const Problem p = make_problem(200, 6, 30);
  const double noise = 0.25, unit_noise = noise / std::pow(p.unit.target_norm(0), 2);
  const std::vector<Index> kept{0, 2, 3};
  VectorXd alpha = VectorXd{{0.3, 2.0, 4.0}};
  const auto at = ident::posterior(p.unit, kept, lambda_of(p, kept, alpha, noise));
  const double before = evidence_by_rows(p, kept, alpha, noise);

  SECTION("addition at its best alpha") {
    const double lambda = ident::best_lambda(at.sparsity(1), std::pow(at.quality(1), 2) / unit_noise);
    REQUIRE(std::isfinite(lambda));
    std::vector<Index> more = kept;
    more.push_back(1);
    VectorXd alphas(4);
    alphas << alpha, lambda / noise * std::pow(p.unit.column_norm(1), 2);
    const double q = at.quality(1) * at.quality(1) / at.sparsity(1) / unit_noise;
    CHECK(ident::evidence_gain(q) == Approx(2.0 * (evidence_by_rows(p, more, alphas, noise) - before)).epsilon(1e-8));
  }
  SECTION("exchange of a kept for a left-out term") {
    // As the search sums it up: the fraction of the leaving term lost, the gain of the other beside those that stay
    // won.
    const double contribution = ident::evidence_contribution(at.sparsity(2), std::pow(at.quality(2), 2) / unit_noise,
                                                             lambda_of(p, kept, alpha, noise)(1));
    const std::vector<Index> stay{0, 3};
    const VectorXd stay_alpha{{0.3, 4.0}};
    const auto without = ident::posterior(p.unit, stay, lambda_of(p, stay, stay_alpha, noise));
    const double q = without.quality(1) * without.quality(1) / without.sparsity(1) / unit_noise;
    const double lambda = ident::best_lambda(without.sparsity(1), std::pow(without.quality(1), 2) / unit_noise);
    REQUIRE(std::isfinite(lambda));
    const VectorXd alphas{{0.3, 4.0, lambda / noise * std::pow(p.unit.column_norm(1), 2)}};
    CHECK(ident::evidence_gain(q) - contribution ==
          Approx(2.0 * (evidence_by_rows(p, {0, 3, 1}, alphas, noise) - before)).epsilon(1e-8));
  }
  SECTION("removal and re-estimation of a kept term") {
    const double contribution = ident::evidence_contribution(at.sparsity(2), std::pow(at.quality(2), 2) / unit_noise,
                                                             lambda_of(p, kept, alpha, noise)(1));
    const double without = evidence_by_rows(p, {0, 3}, VectorXd{{0.3, 4.0}}, noise);
    CHECK(contribution == Approx(2.0 * (before - without)).epsilon(1e-8));
    const double lambda = ident::best_lambda(at.sparsity(2), std::pow(at.quality(2), 2) / unit_noise);
    const double settled =
        ident::evidence_contribution(at.sparsity(2), std::pow(at.quality(2), 2) / unit_noise, lambda);
    alpha(1) = lambda / noise * std::pow(p.unit.column_norm(2), 2);
    // The difference of two evidences of size 300 is itself known to about 1e-11 only.
    CHECK(settled - contribution == Approx(2.0 * (evidence_by_rows(p, kept, alpha, noise) - before)).margin(1e-9));
  }
}

TEST_CASE("the posterior solves its defining equation", "[ident][posterior]") {
  const Problem p = make_problem(400, 7, 40);
  const std::vector<Index> kept{0, 1, 2, 5};
  const VectorXd lambda = VectorXd{{1e-3, 0.1, 2.0, 1e-6}};
  const auto at = ident::posterior(p.unit, kept, lambda);
  MatrixXd A(p.unit.A.rows(), 4);
  for (Index j = 0; j < 4; ++j) A.col(j) = p.unit.A.col(kept[static_cast<std::size_t>(j)]);
  const MatrixXd system = A.transpose() * A + MatrixXd(lambda.asDiagonal());
  // Rounding of a 4 x 4 system of unit-norm columns, condition about 20.
  CHECK((system * at.mean - A.transpose() * p.unit.Y).norm() <= 1e-13);
  CHECK((system * at.root * at.root.transpose() - MatrixXd::Identity(4, 4)).norm() <= 1e-12);
  CHECK(at.residual(0, 0) == Approx((p.unit.Y - A * at.mean).squaredNorm()).epsilon(1e-12));
}

}  // namespace test_regression_posterior
