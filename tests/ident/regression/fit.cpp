#include "ident/regression/fit.hpp"

#include <rapidcheck/catch.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "ident/regression/methods.hpp"
#include "ident/regression/multi_rvm.hpp"
#include "support/random.hpp"

namespace test_fit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using support::gaussian;
using Support = std::vector<Index>;

namespace {

struct Data {
  MatrixXd phi;
  VectorXd target;
};

const VectorXd truth{{3.0, -0.5, 1.5}};
const Support true_terms{1, 4, 7};

// Three true terms of ten, noise a fraction of the target's standard deviation.
Data sparse_problem(unsigned seed, double noise, Index rows = 2000) {
  Data d{gaussian(rows, 10, seed), {}};
  d.target = 3.0 * d.phi.col(1) - 0.5 * d.phi.col(4) + 1.5 * d.phi.col(7);
  d.target += noise * truth.norm() * gaussian(rows, 1, seed + 1000);
  return d;
}

std::vector<ident::Fit> all_selecting_fits(const ident::RFactor& data) {
  return {ident::fit_fast_rvm(data), ident::fit_slow_rvm(data), ident::fit_stlsq(data, {.threshold = 0.05}),
          ident::fit_lasso(data)};
}

}  // namespace

TEST_CASE("every method finds the true terms of a sparse problem", "[ident][fit]") {
  for (const double noise : {0.01, 0.1}) {
    const Data d = sparse_problem(1, noise);
    for (const auto& fit : all_selecting_fits(ident::r_factor(d.phi, d.target))) {
      INFO(ident::to_string(fit.method) << " at noise " << noise);
      CHECK(fit.status == ident::FitStatus::converged);
      if (fit.method == ident::Method::lasso) {  // the lasso is known to let false terms in
        CHECK(std::includes(fit.relevant.begin(), fit.relevant.end(), true_terms.begin(), true_terms.end()));
        continue;
      }
      REQUIRE(fit.relevant == true_terms);
      for (Index j = 0; j < 3; ++j)  // five standard deviations: one test in 1.7 million fails by chance
        CHECK(std::abs(fit.mean(j) - truth(j)) <= 5.0 * std::sqrt(fit.covariance(j, j)));
    }
  }
}

TEST_CASE("slow and fast RVM agree in mean and standard deviation on the same support", "[ident][fit]") {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Data d = sparse_problem(seed, 0.1);
    const auto data = ident::r_factor(d.phi, d.target);
    const auto fast = ident::fit_fast_rvm(data), slow = ident::fit_slow_rvm(data);
    REQUIRE(fast.relevant == slow.relevant);
    CHECK((fast.mean - slow.mean).norm() <= 1e-8 * fast.mean.norm());
    CHECK((fast.covariance - slow.covariance).norm() <= 1e-7 * fast.covariance.norm());
    CHECK(fast.noise_variance == Approx(slow.noise_variance).epsilon(1e-7));
  }
}

TEST_CASE("the noise estimate is the noise and the 95 % intervals cover", "[ident][fit]") {
  int covered = 0, total = 0;
  for (unsigned seed = 100; seed < 300; ++seed) {
    const Data d = sparse_problem(seed, 0.1, 500);
    const auto fit = ident::fit_fast_rvm(ident::r_factor(d.phi, d.target));
    if (fit.relevant != true_terms) continue;
    for (Index j = 0; j < 3; ++j, ++total)
      covered += std::abs(fit.mean(j) - truth(j)) <= 1.96 * std::sqrt(fit.covariance(j, j));
    CHECK(std::sqrt(fit.noise_variance) == Approx(0.1 * truth.norm()).epsilon(0.15));  // sd of the estimate is 3 %
  }
  REQUIRE(total >= 590);
  // 0.95 +- 4 standard errors of 600 binomial draws.
  CHECK(std::abs(static_cast<double>(covered) / total - 0.95) <= 4.0 * std::sqrt(0.95 * 0.05 / total));
}

TEST_CASE("scaling a column scales its coefficient back, permuting columns permutes the answer", "[ident][fit]") {
  rc::prop("equivariance", [] {
    const auto seed = *rc::gen::inRange(1u, 1000u);
    const auto exponent = *rc::gen::inRange(-40, 40);
    const auto turn = *rc::gen::inRange(0, 10);
    const Data d = sparse_problem(seed, 0.1, 400);
    const auto plain = ident::fit_fast_rvm(ident::r_factor(d.phi, d.target));
    MatrixXd phi(d.phi.rows(), 10);
    const auto source = [&](Index j) { return (7 * j + turn) % 10; };  // a permutation, since 7 and 10 are coprime
    const auto scale = [&](Index j) { return std::ldexp(1.0, j % 2 == 0 ? exponent : 0); };
    for (Index j = 0; j < 10; ++j) phi.col(j) = d.phi.col(source(j)) * scale(j);
    const auto moved = ident::fit_fast_rvm(ident::r_factor(phi, d.target));
    RC_ASSERT(moved.relevant.size() == plain.relevant.size());
    for (std::size_t j = 0; j < moved.relevant.size(); ++j) {
      const Index column = moved.relevant[j];
      const auto at = std::find(plain.relevant.begin(), plain.relevant.end(), source(column)) - plain.relevant.begin();
      RC_ASSERT(at < static_cast<std::ptrdiff_t>(plain.relevant.size()));
      const double back = moved.mean(static_cast<Index>(j)) * scale(column);
      // Another order of columns rounds differently; log alpha is settled to 1e-6 and moves a mean by less than that.
      RC_ASSERT(std::abs(back - plain.mean(at)) <= 1e-7 * std::abs(plain.mean(at)));
    }
  });
}

TEST_CASE("mean, alpha and covariance of a fit solve the defining equation in the caller's units", "[ident][fit]") {
  Data d = sparse_problem(11, 0.1);
  for (Index j = 0; j < 10; ++j) d.phi.col(j) *= std::pow(10.0, static_cast<double>(j % 5) - 2.0);
  const auto data = ident::r_factor(d.phi, d.target);
  for (const auto& fit : {ident::fit_fast_rvm(data), ident::fit_slow_rvm(data), ident::fit_multi_rvm(data).rows.front(),
                          ident::fit_ols(data)}) {
    INFO(ident::to_string(fit.method));
    const MatrixXd kept = d.phi(Eigen::all, fit.relevant);
    const MatrixXd precision = MatrixXd(fit.alpha.asDiagonal()) + kept.transpose() * kept / fit.noise_variance;
    const VectorXd right = kept.transpose() * d.target / fit.noise_variance;
    // Sums over 2000 rows, rounded: some 1e-14 of their size.
    CHECK((precision * fit.mean - right).cwiseAbs().cwiseQuotient(right.cwiseAbs()).maxCoeff() <= 1e-11);
    const MatrixXd whole = precision * fit.covariance;  // columns of very different units: compared entry by entry
    for (Index i = 0; i < whole.rows(); ++i)
      for (Index j = 0; j < whole.cols(); ++j)
        CHECK(std::abs(whole(i, j) - (i == j ? 1.0 : 0.0)) <= 1e-11 * std::sqrt(precision(i, i) / precision(j, j)));
  }
}

TEST_CASE("type-II selection keeps false terms and evidence selection does not", "[ident][fit]") {
  int evidence = 0, type2 = 0;
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Data d = sparse_problem(700 + seed, 0.1, 1000);
    const auto data = ident::r_factor(d.phi, d.target);
    evidence += ident::fit_fast_rvm(data).relevant == true_terms;
    type2 += ident::fit_fast_rvm(data, {.selection = ident::Selection::type2}).relevant == true_terms;
  }
  CHECK(evidence >= 49);  // a false term passes tau = ln m + 2 ln b about once in 5000
  CHECK(type2 <= 15);     // seven irrelevant terms at 32 % each: 7 % of draws expected exact
}

TEST_CASE("the evidence never falls along the steps of a fast fit", "[ident][fit]") {
  const Data d = sparse_problem(9, 0.1);
  const auto fit = ident::fit_fast_rvm(ident::r_factor(d.phi, d.target), {.selection = ident::Selection::type2});
  REQUIRE(fit.steps.size() > 3);
  for (std::size_t i = 1; i < fit.steps.size(); ++i)
    CHECK(fit.steps[i].log_evidence >= fit.steps[i - 1].log_evidence - 1e-7);
  CHECK(fit.steps.back().log_evidence == Approx(fit.log_evidence).epsilon(1e-12));
}

TEST_CASE("problems with nothing to find end in a status", "[ident][fit]") {
  const MatrixXd phi = gaussian(50, 4, 60);
  SECTION("zero target") {
    for (const auto& fit : all_selecting_fits(ident::r_factor(phi, VectorXd::Zero(50)))) {
      CHECK(fit.status == ident::FitStatus::zero_target);
      CHECK(fit.relevant.empty());
    }
  }
  SECTION("noise alone") {
    const auto fit = ident::fit_fast_rvm(ident::r_factor(phi, gaussian(50, 1, 61)));
    CHECK(fit.status == ident::FitStatus::no_relevant_term);
    CHECK(fit.mean.size() == 0);
  }
  SECTION("a zero column") {
    MatrixXd holed = phi;
    holed.col(2).setZero();
    for (const auto& fit : all_selecting_fits(ident::r_factor(holed, phi.col(0) * 2.0 + 0.01 * gaussian(50, 1, 62))))
      CHECK(fit.relevant.front() == 0);
  }
  SECTION("no rows at all") {
    CHECK(ident::fit_fast_rvm(ident::r_factor(MatrixXd(0, 3), MatrixXd(0, 1))).status ==
          ident::FitStatus::too_few_rows);
    CHECK(ident::fit_ols(ident::r_factor(phi.topRows(3), VectorXd::Ones(3))).status == ident::FitStatus::too_few_rows);
  }
  SECTION("fewer rows than terms") {
    const MatrixXd wide = gaussian(8, 20, 63);
    const auto fit = ident::fit_fast_rvm(ident::r_factor(wide, wide.col(3) * 2.0));
    CHECK(fit.mean.allFinite());
    CHECK(fit.relevant.size() <= 8);
  }
  SECTION("two equal columns") {
    MatrixXd twins = phi;
    twins.col(3) = twins.col(1);
    const auto data = ident::r_factor(twins, phi.col(1) + 0.1 * gaussian(50, 1, 64));
    CHECK(ident::fit_fast_rvm(data).relevant.size() == 1);
    CHECK(ident::fit_ols(data).status == ident::FitStatus::rank_deficient);
    CHECK(ident::fit_slow_rvm(data).mean.allFinite());
  }
}

TEST_CASE("an exact fit keeps its support and a finite noise floor", "[ident][fit]") {
  const Data d = sparse_problem(5, 0.0);
  const auto data = ident::r_factor(d.phi, d.target);
  for (const auto& fit : {ident::fit_fast_rvm(data), ident::fit_slow_rvm(data)}) {
    INFO(ident::to_string(fit.method) << " " << ident::to_string(fit.status));
    REQUIRE(fit.relevant == true_terms);
    CHECK((fit.mean - truth).norm() <= 1e-12);
    CHECK(fit.noise_variance > 0.0);
    CHECK(std::isfinite(fit.log_evidence));
  }
}

TEST_CASE("noise from 1e-2 down to nothing: the right support in twenty moves", "[ident][fit]") {
  for (const double noise : {1e-2, 1e-4, 1e-6, 1e-8, 0.0}) {
    const Data d = sparse_problem(6, noise);
    const auto fit = ident::fit_fast_rvm(ident::r_factor(d.phi, d.target));
    INFO("noise " << noise);
    CHECK(fit.relevant == true_terms);
    CHECK(fit.status == ident::FitStatus::converged);
    CHECK(fit.iterations <= 20);
  }
}

TEST_CASE("an exact target of two columns is settled in ten moves, whatever the number of rows", "[ident][fit]") {
  for (const Index rows : {20, 200, 5000}) {
    const MatrixXd phi = gaussian(rows, 8, 80);
    const auto fit = ident::fit_fast_rvm(ident::r_factor(phi, 2.0 * phi.col(3) - phi.col(5)));
    INFO(rows << " rows, " << fit.iterations << " moves");
    CHECK(fit.relevant == Support{3, 5});
    CHECK(fit.iterations <= 10);
  }
}

TEST_CASE("a search cut short says so and keeps its best so far", "[ident][fit]") {
  const Data d = sparse_problem(7, 0.1);
  const auto data = ident::r_factor(d.phi, d.target);
  const auto first = ident::fit_fast_rvm(data, {.max_iterations = 2}),
             again = ident::fit_fast_rvm(data, {.max_iterations = 2});
  CHECK(first.status == ident::FitStatus::iteration_limit);
  CHECK(first.relevant.size() == 2);
  CHECK(first.mean == again.mean);
  CHECK(ident::fit_slow_rvm(data, {.max_iterations = 1}).status == ident::FitStatus::iteration_limit);
  CHECK(ident::fit_stlsq(data, {.threshold = 0.05, .max_iterations = 1}).status == ident::FitStatus::iteration_limit);
}

TEST_CASE("least squares on some terms is that of a library of them alone", "[ident][fit]") {
  const Data d = sparse_problem(8, 0.1);
  const auto some = ident::fit_ols(ident::r_factor(d.phi, d.target), true_terms);
  const auto alone = ident::fit_ols(ident::r_factor(d.phi(Eigen::all, true_terms), d.target));
  CHECK(some.relevant == true_terms);
  CHECK(some.mean.isApprox(alone.mean, 1e-12));  // two ways of solving ten well-conditioned columns
  CHECK(some.covariance.isApprox(alone.covariance, 1e-12));
}

TEST_CASE("a library of which every term is kept is remarked on", "[ident][fit]") {
  const MatrixXd phi = gaussian(500, 4, 70);
  const VectorXd target = phi * VectorXd::Ones(4) + 0.1 * gaussian(500, 1, 71);
  const auto fit = ident::fit_fast_rvm(ident::r_factor(phi, target));
  REQUIRE(fit.relevant.size() == 4);
  REQUIRE(fit.remarks.size() == 1);
  CHECK_THAT(fit.remarks.front(), Catch::Contains("every candidate term was kept"));
}

TEST_CASE("options out of their range are refused", "[ident][fit]") {
  const Data d = sparse_problem(1, 0.1, 100);
  const auto data = ident::r_factor(d.phi, d.target);
  CHECK_THROWS_AS(ident::fit_fast_rvm(data, {.initial_noise_fraction = 1.0}), std::invalid_argument);
  CHECK_THROWS_AS(ident::fit_stlsq(data, {.threshold = -1.0}), std::invalid_argument);
  CHECK_THROWS_AS(ident::fit_ridge(data, {.lambda = 0.0}), std::invalid_argument);
  CHECK_THROWS_AS(ident::fit_lasso(data, {.path_length = 1}), std::invalid_argument);
  CHECK_THROWS_AS(ident::method_named("svm"), std::invalid_argument);
}

TEST_CASE("data in any unit give the same fit, to the bit where the unit is a power of two", "[ident][fit]") {
  const Data d = sparse_problem(5, 0.1, 400);
  const ident::RFactor plain = ident::r_factor(d.phi, d.target);
  const auto expected = all_selecting_fits(plain);
  for (const int of_phi : {-600, 0, 600})
    for (const int of_target : {-600, 0, 600}) {
      if (of_phi * of_target < 0) continue;  // coefficients of 2^1200
      CAPTURE(of_phi, of_target);
      const auto fits =
          all_selecting_fits(ident::r_factor(d.phi * std::ldexp(1.0, of_phi), d.target * std::ldexp(1.0, of_target)));
      for (std::size_t i = 0; i < fits.size(); ++i) {
        CHECK(fits[i].status == expected[i].status);
        CHECK(fits[i].relevant == expected[i].relevant);
        CHECK(fits[i].mean * std::ldexp(1.0, of_phi - of_target) == expected[i].mean);
        // The squares 2^-1200 and 2^1200 are beyond a double: no variance then, never a wrong one.
        CHECK(std::isfinite(fits[i].noise_variance) == (of_target == 0));
        CHECK(fits[i].covariance.allFinite() == (of_target == of_phi));
      }
    }
}

}  // namespace test_fit
