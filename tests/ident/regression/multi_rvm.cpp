#include "ident/regression/multi_rvm.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "support/random.hpp"

namespace test_regression_multi_rvm {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using support::gaussian;
using Support = std::vector<Index>;

namespace {

struct Data {
  MatrixXd phi, truth, noise_covariance, targets;
};

// Three targets on eight columns with different supports and correlated noise.
Data three_targets(unsigned seed, Index rows) {
  Data d{gaussian(rows, 8, seed), MatrixXd::Zero(8, 3), {}, {}};
  d.truth(1, 0) = 2.0;
  d.truth(1, 1) = -1.0;
  d.truth(4, 1) = 0.7;
  d.truth(6, 2) = 30.0;
  const MatrixXd mix = (MatrixXd(3, 3) << 0.3, 0, 0, 0.1, 0.2, 0, 1.0, 0.5, 2.0).finished();
  d.noise_covariance = mix * mix.transpose();
  d.targets = d.phi * d.truth + gaussian(rows, 3, seed + 500) * mix.transpose();
  return d;
}

}  // namespace

TEST_CASE("for one target the multi-output fit is the fast RVM", "[ident][multi_rvm]") {
  const Data d = three_targets(1, 500);
  const auto data = ident::r_factor(d.phi, d.targets.col(1));
  const auto one = ident::fit_fast_rvm(data);
  const auto multi = ident::fit_multi_rvm(data);
  REQUIRE(multi.relevant == one.relevant);
  CHECK((multi.mean.col(0) - one.mean).norm() <= 1e-8 * one.mean.norm());
  CHECK(multi.log_evidence == Approx(one.log_evidence).epsilon(1e-9));
  CHECK((multi.standard_deviation().col(0) - one.covariance.diagonal().cwiseSqrt()).norm() <=
        1e-6 * one.covariance.diagonal().cwiseSqrt().norm());
}

TEST_CASE("shared relevance keeps the union of the supports, the second stage each row's own", "[ident][multi_rvm]") {
  for (unsigned seed = 10; seed < 30; ++seed) {
    const Data d = three_targets(seed, 1000);
    const auto fit = ident::fit_multi_rvm(ident::r_factor(d.phi, d.targets));
    REQUIRE(fit.status == ident::FitStatus::converged);
    CHECK(fit.relevant == Support{1, 4, 6});
    REQUIRE(fit.rows.size() == 3);
    CHECK(fit.rows[0].relevant == Support{1});
    CHECK(fit.rows[1].relevant == Support{1, 4});
    CHECK(fit.rows[2].relevant == Support{6});
  }
}

TEST_CASE("its evidence is that of the whole matrix-normal model", "[ident][multi_rvm]") {
  const Index rows = 60;
  const Data d = three_targets(2, rows);
  const auto fit = ident::fit_multi_rvm(ident::r_factor(d.phi, d.targets));
  // Covariance of vec(T): Omega (x) (I + Phi Lambda^-1 Phi').
  const MatrixXd kept = d.phi(Eigen::all, fit.relevant);
  const MatrixXd inner =
      MatrixXd::Identity(rows, rows) + kept * fit.lambda.cwiseInverse().asDiagonal() * kept.transpose();
  MatrixXd whole(3 * rows, 3 * rows);
  for (Index j = 0; j < 3; ++j)
    for (Index k = 0; k < 3; ++k) whole.block(j * rows, k * rows, rows, rows) = fit.noise_covariance(j, k) * inner;
  const Eigen::LLT<MatrixXd> llt(whole);
  const VectorXd stacked = d.targets.reshaped();
  const double expected =
      -0.5 * (static_cast<double>(3 * rows) * std::log(2.0 * std::numbers::pi) +
              2.0 * MatrixXd(llt.matrixL()).diagonal().array().log().sum() + stacked.dot(llt.solve(stacked)));
  CHECK(fit.log_evidence == Approx(expected).epsilon(1e-9));
}

TEST_CASE("standard deviations of the shared fit are those of its errors", "[ident][multi_rvm]") {
  int covered = 0, total = 0;
  MatrixXd omega = MatrixXd::Zero(3, 3);
  for (unsigned seed = 100; seed < 300; ++seed) {
    const Data d = three_targets(seed, 400);
    const auto fit = ident::fit_multi_rvm(ident::r_factor(d.phi, d.targets));
    if (fit.relevant != Support{1, 4, 6}) continue;
    omega += fit.noise_covariance / 200.0;
    const MatrixXd z = (fit.mean - d.truth(fit.relevant, Eigen::all)).cwiseQuotient(fit.standard_deviation());
    covered += static_cast<int>((z.array().abs() <= 1.96).count());
    total += 9;
  }
  REQUIRE(total >= 1700);
  CHECK(std::abs(static_cast<double>(covered) / total - 0.95) <= 4.0 * std::sqrt(0.95 * 0.05 / total));
  // Each entry is known to about sqrt(2 / 400 / 200) = 0.5 % of the standard deviations.
  const Data d = three_targets(100, 400);
  for (Index j = 0; j < 3; ++j)
    for (Index k = 0; k < 3; ++k)
      CHECK(std::abs(omega(j, k) - d.noise_covariance(j, k)) <=
            0.03 * std::sqrt(d.noise_covariance(j, j) * d.noise_covariance(k, k)));
}

TEST_CASE("targets that cannot be fitted end in a status", "[ident][multi_rvm]") {
  const MatrixXd phi = gaussian(50, 4, 7);
  MatrixXd targets = gaussian(50, 2, 8);
  const auto ends_as = [&](const MatrixXd& wanted, ident::FitStatus status) {
    const auto fit = ident::fit_multi_rvm(ident::r_factor(phi, wanted));
    CHECK(fit.status == status);
    REQUIRE(static_cast<Index>(fit.rows.size()) == wanted.cols());
    for (const ident::Fit& row : fit.rows) {
      CHECK(row.status == status);
      CHECK(row.method == ident::Method::multi_rvm);
      CHECK(row.relevant.empty());
      CHECK(row.evidence_gain.size() == 4);
    }
  };
  ends_as(targets, ident::FitStatus::no_relevant_term);
  ends_as(targets.col(0), ident::FitStatus::no_relevant_term);
  targets.col(1).setZero();
  ends_as(targets, ident::FitStatus::zero_target);
  ends_as(targets.col(1), ident::FitStatus::zero_target);
  targets << phi.col(0), phi.col(1) * 2.0;  // exact
  const auto exact = ident::fit_multi_rvm(ident::r_factor(phi, targets));
  CHECK(exact.relevant == Support{0, 1});
  CHECK(exact.mean.allFinite());
  CHECK(exact.noise_covariance.allFinite());
}

TEST_CASE("a library in which no term is conspicuous alone is searched from the full model too", "[ident][multi_rvm]") {
  // Wampler's two exact quintics on x = 0 .. 20: the forward search alone stops at two terms.
  const VectorXd x = VectorXd::LinSpaced(21, 0.0, 20.0);
  MatrixXd phi(21, 6), targets(21, 2);
  for (Index j = 0; j < 6; ++j) phi.col(j) = x.array().pow(static_cast<double>(j));
  targets.col(0) = phi.rowwise().sum();
  targets.col(1) = phi * VectorXd{{1.0, 0.1, 0.01, 0.001, 0.0001, 0.00001}};
  const auto fit = ident::fit_multi_rvm(ident::r_factor(phi, targets));
  CHECK(fit.status == ident::FitStatus::converged);
  CHECK(fit.relevant == Support{0, 1, 2, 3, 4, 5});
  for (const ident::Fit& row : fit.rows) CHECK(row.relevant == Support{0, 1, 2, 3, 4, 5});
}

TEST_CASE("where a shared search ends, no exchange of a kept for a left-out term raises its criterion",
          "[ident][multi_rvm]") {
  // Powers of an offset signal hide one another: a search without exchanges ends too low for 7 of these 20 seeds.
  for (unsigned seed = 0; seed < 20; ++seed) {
    const VectorXd x = (gaussian(400, 1, 3000 + seed).array() + 2.0).matrix();
    MatrixXd phi(400, 7), targets(400, 2);
    for (Index j = 0; j < 7; ++j) phi.col(j) = x.array().pow(static_cast<double>(j));
    targets << phi.col(1) - 0.3 * phi.col(3), phi.col(2) + 0.1 * phi.col(4);
    targets += gaussian(400, 2, 4000 + seed);
    const auto end = ident::fit_multi_rvm(ident::r_factor(phi, targets));
    const auto criterion = [&](const ident::MultiFit& fit) {
      return 2.0 * fit.log_evidence - end.tau * static_cast<double>(fit.relevant.size());
    };
    for (std::size_t k = 0; k < end.relevant.size(); ++k)
      for (Index i = 0; i < 7; ++i) {
        if (std::find(end.relevant.begin(), end.relevant.end(), i) != end.relevant.end()) continue;
        Support swapped = end.relevant;
        swapped[k] = i;
        const auto other = ident::fit_multi_rvm(ident::r_factor(phi(Eigen::all, swapped), targets), {.tau = end.tau});
        CAPTURE(seed, end.relevant, swapped);
        CHECK(criterion(other) <= criterion(end) + 1e-6);  // log alpha is settled to 1e-6
      }
  }
}

TEST_CASE("targets that are multiples of one another have a noise covariance and finite figures",
          "[ident][multi_rvm]") {
  const MatrixXd phi = gaussian(100, 4, 30);
  MatrixXd targets(100, 3);
  targets.col(0) = phi.col(0) - phi.col(2) + 0.1 * gaussian(100, 1, 31);
  targets.col(1) = -3.0 * targets.col(0);
  targets.col(2) = phi.col(1) + 0.1 * gaussian(100, 1, 32);
  const auto fit = ident::fit_multi_rvm(ident::r_factor(phi, targets));
  CHECK(fit.relevant == Support{0, 1, 2});
  CHECK(std::isfinite(fit.log_evidence));
  CHECK(fit.standard_deviation().allFinite());
  CHECK(fit.rows[0].relevant == Support{0, 2});
  CHECK(fit.rows[1].relevant == Support{0, 2});
  CHECK(fit.noise_covariance(1, 1) == Approx(9.0 * fit.noise_covariance(0, 0)));
}

}  // namespace test_regression_multi_rvm
