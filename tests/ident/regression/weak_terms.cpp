#include "ident/regression/weak_terms.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <catch2/catch.hpp>
#include <cmath>

#include "ident/regression/fit.hpp"
#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// 200 rows, 4 columns; the second resembles the first (correlation 0.8), the others nothing.
struct Table {
  MatrixXd phi;
  VectorXd noise;
  explicit Table(unsigned seed) {
    const MatrixXd values = support::gaussian(200, 5, seed);
    phi = values.leftCols(4);
    phi.col(1) = 0.8 * phi.col(0) + 0.6 * values.col(1);
    noise = values.col(4);
  }
};

}  // namespace

TEST_CASE("terms that resemble no kept one leave its interval as it is", "[ident][weak_terms]") {
  MatrixXd phi = Table(1).phi;
  const MatrixXd q = phi.householderQr().householderQ() * MatrixXd::Identity(200, 4);  // orthonormal columns
  const VectorXd target = 5.0 * q.col(0) + 0.1 * Table(2).noise;
  const ident::Fit fit = ident::fit_fast_rvm(ident::r_factor(q, target));
  REQUIRE(fit.relevant == std::vector<Index>{0});
  // Only the noise differs, by what a weak term explains of it: its variance is 1 / 200 less for a term of 1 deviation.
  CHECK(fit.covariance_weak(0, 0) == Approx(fit.covariance(0, 0)).epsilon(0.05));
}

TEST_CASE("an interval covers though a term like it is too weak to be kept", "[ident][weak_terms]") {
  int covered = 0, covered_by_noise = 0, without = 0;
  for (unsigned seed = 0; seed < 1000; ++seed) {
    const Table table(100 + seed);
    // The second term's t is 0.25 sqrt(200) 0.6 = 2.1: too little for tau = ln 200 + 2 ln 4 = 8.
    const VectorXd target = 3.0 * table.phi.col(0) + 0.25 * table.phi.col(1) + table.noise;
    const ident::Fit fit = ident::fit_fast_rvm(ident::r_factor(table.phi, target));
    if (fit.relevant != std::vector<Index>{0}) continue;
    ++without;
    const double error = std::abs(fit.mean(0) - 3.0);
    covered += error <= 1.96 * std::sqrt(fit.covariance_weak(0, 0));
    covered_by_noise += error <= 1.96 * std::sqrt(fit.covariance(0, 0));
  }
  REQUIRE(without > 600);
  CHECK(covered >= 0.80 * without);
  CHECK(covered_by_noise <= 0.35 * without);  // 0.2 of bias is 2.8 deviations: 0.2
}

TEST_CASE("a weak term that is kept where noise makes it large is covered", "[ident][weak_terms]") {
  constexpr double coefficient = 0.14;  // t = 0.14 sqrt(200) 0.6 = 1.2; tau = 8 asks for 3.4: 1.4 % of the draws
  int kept = 0, covered = 0, covered_by_noise = 0;
  for (unsigned seed = 0; seed < 6000; ++seed) {
    const Table table(10000 + seed);
    const VectorXd target = 3.0 * table.phi.col(0) + coefficient * table.phi.col(1) + table.noise;
    const ident::Fit fit = ident::fit_fast_rvm(ident::r_factor(table.phi, target));
    if (fit.relevant != std::vector<Index>{0, 1}) continue;
    ++kept;
    const double error = std::abs(fit.mean(1) - coefficient);
    covered += error <= 1.96 * std::sqrt(fit.covariance_weak(1, 1));
    covered_by_noise += error <= 1.96 * std::sqrt(fit.covariance(1, 1));
  }
  REQUIRE(kept > 30);
  CHECK(covered >= 0.75 * kept);  // all but those that noise lifts beyond doubt: 0.87, less 4 standard errors
  CHECK(covered_by_noise <= 0.3 * kept);
}

TEST_CASE("a term beyond doubt keeps its interval, one in doubt has zero within it", "[ident][weak_terms]") {
  const Table table(13);
  const VectorXd target = 3.0 * table.phi.col(0) + 0.7 * table.phi.col(1) + table.noise;
  const ident::Fit fit = ident::fit_fast_rvm(ident::r_factor(table.phi, target));
  REQUIRE(fit.relevant == std::vector<Index>{0, 1});
  const ident::UnitProblem problem = ident::unit_problem(ident::r_factor(table.phi, target));
  const VectorXd lambda = VectorXd::Constant(2, ident::flat_lambda);
  const double noise = fit.noise_variance / target.squaredNorm();
  const auto covariance_at = [&](double tau) {
    return ident::covariance_with_weak_terms(problem, fit.relevant, lambda, noise, tau);
  };
  const ident::Posterior at = ident::posterior(problem, fit.relevant, lambda);
  const double gain = ident::evidence_gain(at.quality(1) * at.quality(1) / at.sparsity(1) / noise);
  const MatrixXd sure = covariance_at(0.0), doubted = covariance_at(gain);  // as likely there as not
  CHECK(sure.isApprox(covariance_at(1.0), 1e-4));
  const double mean = at.mean(1);
  CHECK(1.96 * std::sqrt(sure(1, 1)) < std::abs(mean));
  CHECK(doubted(1, 1) - sure(1, 1) == Approx(0.5 * mean * mean).epsilon(1e-6));  // nothing but rounding
  // Without it its part of the target goes to the first, which it resembles by 0.8.
  CHECK(doubted(0, 0) - sure(0, 0) == Approx(0.64 * 0.5 * mean * mean).epsilon(0.15));
}

TEST_CASE("a term left out is doubted less the higher its degree", "[ident][weak_terms]") {
  // The second column, left out, resembles the kept first; only its degree changes.
  const Table table(11);
  ident::RFactor data = ident::r_factor(table.phi, 3.0 * table.phi.col(0) + table.noise);
  const auto std_of = [&](double degree) {
    data.degree = (VectorXd(4) << 1, degree, 3, 3).finished();
    const ident::Fit fit = ident::fit_fast_rvm(data);
    REQUIRE(fit.relevant == std::vector<Index>{0});
    return std::sqrt(fit.covariance_weak(0, 0));
  };
  CHECK(std_of(1) > std_of(2));
  CHECK(std_of(2) > std_of(3));
  // Not known: all are of the first degree.
  data.degree = VectorXd::Ones(4);
  const MatrixXd of_first = ident::fit_fast_rvm(data).covariance_weak;
  data.degree.resize(0);
  CHECK(ident::fit_fast_rvm(data).covariance_weak == of_first);
  // The degree goes with the column.
  data.degree = (VectorXd(4) << 1, 2, 3, 4).finished();
  CHECK(ident::select(ident::merge(data, data), {3, 1}, 0).degree == (VectorXd(2) << 4, 2).finished());
}

TEST_CASE("terms left out by a high threshold, however strong, leave standard deviations that are numbers",
          "[ident][weak_terms]") {
  // The second term's gain is some 200 ln(1e12): the square root of e to that is beyond a double.
  const Table table(9);
  const VectorXd target = 1e3 * table.phi.col(0) + table.phi.col(2) + 1e-6 * table.noise;
  const ident::Fit fit = ident::fit_fast_rvm(ident::r_factor(table.phi, target), {.tau = 1e3});
  REQUIRE_FALSE(fit.relevant.empty());
  CHECK(fit.covariance_weak.allFinite());
  CHECK(fit.covariance_weak.diagonal().minCoeff() > 0.0);
}

TEST_CASE("the covariance with weak terms is one", "[ident][weak_terms]") {
  const Table table(7);
  const VectorXd target = 3.0 * table.phi.col(0) + 2.0 * table.phi.col(1) + 0.1 * table.phi.col(2) + table.noise;
  const ident::Fit fit = ident::fit_fast_rvm(ident::r_factor(table.phi, target));
  REQUIRE(fit.covariance_weak.rows() == static_cast<Index>(fit.relevant.size()));
  CHECK(fit.covariance_weak.isApprox(fit.covariance_weak.transpose(), 1e-12));
  CHECK(Eigen::SelfAdjointEigenSolver<MatrixXd>(fit.covariance_weak).eigenvalues().minCoeff() > 0.0);
  // Type-II selection is the paper's rule: its intervals are those of Eq. 13.
  CHECK(ident::fit_fast_rvm(ident::r_factor(table.phi, target), {.selection = ident::Selection::type2})
            .covariance_weak.size() == 0);
}
