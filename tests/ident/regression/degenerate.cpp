// Targets, libraries and rows that leave little or nothing to find: every method ends in a status that says so.
#include <rapidcheck/catch.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "ident/regression/fit.hpp"
#include "ident/regression/multi_rvm.hpp"
#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using ident::FitStatus;
using support::gaussian;
using Support = std::vector<Index>;

namespace {

std::vector<ident::Fit> all_fits(const ident::RFactor& data) {
  return {ident::fit_fast_rvm(data), ident::fit_slow_rvm(data), ident::fit_multi_rvm(data).rows.front(),
          ident::fit_stlsq(data),    ident::fit_lasso(data),    ident::fit_ridge(data),
          ident::fit_ols(data)};
}

bool bayesian(const ident::Fit& fit) {
  return fit.method == ident::Method::fast_rvm || fit.method == ident::Method::slow_rvm ||
         fit.method == ident::Method::multi_rvm;
}

// Never a coefficient that is no number, never error bars of zero where no row is left to estimate the noise.
void check_whole(const ident::Fit& fit, Index rows) {
  RC_ASSERT(fit.mean.size() == static_cast<Index>(fit.relevant.size()));
  RC_ASSERT(fit.covariance.rows() == fit.mean.size());
  RC_ASSERT(fit.mean.allFinite());
  RC_ASSERT(std::is_sorted(fit.relevant.begin(), fit.relevant.end()));
  if (fit.mean.size() < rows || bayesian(fit)) return;
  RC_ASSERT(std::isnan(fit.noise_variance));
  RC_ASSERT(fit.covariance.array().isNaN().all());
  RC_ASSERT(fit.status == FitStatus::too_few_rows || !fit.no_variance.empty());
}

struct Size {
  Index rows, terms;
  unsigned seed;
};
Size any_size(Index least_rows, Index most_rows) {
  return {*rc::gen::inRange<Index>(least_rows, most_rows), *rc::gen::inRange<Index>(1, 9),
          *rc::gen::inRange(0u, 100000u)};
}

}  // namespace

TEST_CASE("a zero target is a status of every method", "[ident][degenerate]") {
  rc::prop("every draw", [] {
    const auto [rows, terms, seed] = any_size(2, 40);
    for (const auto& fit : all_fits(ident::r_factor(gaussian(rows, terms, seed), VectorXd::Zero(rows)))) {
      RC_ASSERT(fit.status == FitStatus::zero_target);
      RC_ASSERT(fit.relevant.empty());
      check_whole(fit, rows);
    }
  });
}

TEST_CASE("a constant target is the constant term", "[ident][degenerate]") {
  rc::prop("every draw", [] {
    const auto [rows, more, seed] = any_size(20, 60);
    MatrixXd phi(rows, more + 1);
    phi << VectorXd::Ones(rows), gaussian(rows, more, seed);
    const double level = *rc::gen::inRange(1, 1000) * std::pow(10.0, *rc::gen::inRange(-6, 6));
    for (const auto& fit : all_fits(ident::r_factor(phi, VectorXd::Constant(rows, level)))) {
      RC_ASSERT(fit.status == FitStatus::converged);
      check_whole(fit, rows);
      // ridge keeps all, and its penalty of 1e-6 pulls the constant down by as much
      RC_ASSERT(fit.relevant.front() == 0);
      RC_ASSERT(std::abs(fit.mean(0) - level) <= (fit.method == ident::Method::ridge ? 1e-4 : 1e-10) * level);
      if (bayesian(fit) || fit.method == ident::Method::stlsq) RC_ASSERT(fit.relevant == Support{0});
    }
  });
}

TEST_CASE("an exact target of random columns is found exactly, with a noise that is finite and tiny",
          "[ident][degenerate]") {
  rc::prop("every draw", [] {
    const auto [rows, more, seed] = any_size(40, 120);
    const MatrixXd phi = gaussian(rows, more + 2, seed);
    const auto term = *rc::gen::inRange<Index>(0, more + 2);
    const VectorXd target = 2.0 * phi.col(term) - phi.col((term + 1) % (more + 2));
    for (const auto& fit : all_fits(ident::r_factor(phi, target))) {
      RC_ASSERT(fit.status == FitStatus::converged);
      check_whole(fit, rows);
      RC_ASSERT(std::isfinite(fit.noise_variance));
      if (fit.method == ident::Method::ridge || fit.method == ident::Method::ols) continue;
      RC_ASSERT(fit.relevant.size() == 2u);
      RC_ASSERT(fit.noise_variance < 1e-24);
    }
  });
}

TEST_CASE("fewer rows than terms, or as many, is reported and never given error bars of zero", "[ident][degenerate]") {
  rc::prop("every draw", [] {
    const auto seed = *rc::gen::inRange(0u, 100000u);
    const auto terms = *rc::gen::inRange<Index>(3, 12), rows = *rc::gen::inRange<Index>(2, terms + 1);
    const MatrixXd phi = gaussian(rows, terms, seed);
    const bool exact = *rc::gen::arbitrary<bool>();
    const VectorXd target = exact ? VectorXd(2.0 * phi.col(terms - 1)) : VectorXd(gaussian(rows, 1, seed + 1));
    for (const auto& fit : all_fits(ident::r_factor(phi, target))) {
      check_whole(fit, rows);
      if (fit.method == ident::Method::ols) RC_ASSERT(fit.status == FitStatus::too_few_rows);
      if (fit.method == ident::Method::stlsq && rows < terms) RC_ASSERT(fit.status == FitStatus::too_few_rows);
      if (fit.method == ident::Method::lasso) RC_ASSERT(static_cast<Index>(fit.relevant.size()) < rows);
      if (static_cast<Index>(fit.relevant.size()) >= rows && fit.method != ident::Method::ridge)
        RC_ASSERT(fit.status == FitStatus::too_few_rows);
    }
  });
}

TEST_CASE("two equal columns are never kept together but by ridge", "[ident][degenerate]") {
  rc::prop("every draw", [] {
    const auto [rows, more, seed] = any_size(40, 100);
    const auto factor = *rc::gen::inRange(1, 1000) * 0.01;
    MatrixXd phi(rows, more + 2);
    phi << gaussian(rows, more + 1, seed), VectorXd::Zero(rows);
    phi.col(more + 1) = factor * phi.col(0);
    const VectorXd target = phi.col(0) + 0.1 * gaussian(rows, 1, seed + 1);
    for (const auto& fit : all_fits(ident::r_factor(phi, target))) {
      check_whole(fit, rows);
      const auto& kept = fit.relevant;
      const bool both =
          std::binary_search(kept.begin(), kept.end(), 0) && std::binary_search(kept.begin(), kept.end(), more + 1);
      RC_ASSERT(both == (fit.method == ident::Method::ridge));
      RC_ASSERT(!kept.empty());
      if (fit.method != ident::Method::ols && fit.method != ident::Method::stlsq) continue;
      RC_ASSERT(fit.status == FitStatus::rank_deficient);
      RC_ASSERT(fit.dependent.size() == 1u);
      RC_ASSERT(fit.dependent.front().term == more + 1);
      RC_ASSERT(fit.dependent.front().of == Support{0});
    }
  });
}

TEST_CASE("of columns that add up to one another the last is left out and named", "[ident][degenerate]") {
  const MatrixXd base = gaussian(2000, 3, 5);
  MatrixXd phi(2000, 5);
  phi << base, base.col(0) + base.col(1), base.col(2).cwiseAbs2();  // 1, x, v, x + v ...
  const VectorXd target = 3.0 * base.col(0) - 2.0 * base.col(1) + 0.1 * gaussian(2000, 1, 6);
  const auto data = ident::r_factor(phi, target);
  for (const auto& fit : {ident::fit_ols(data), ident::fit_stlsq(data)}) {
    INFO(ident::to_string(fit.method));
    CHECK(fit.status == FitStatus::rank_deficient);
    REQUIRE(fit.dependent.size() == 1);
    CHECK(fit.dependent.front().term == 3);
    CHECK(fit.dependent.front().of == Support{0, 1});
    CHECK(fit.mean(0) == Approx(3.0).epsilon(0.01));
    CHECK(fit.mean(1) == Approx(-2.0).epsilon(0.01));
    CHECK(fit.condition_number < 2.0);
  }
  // Ridge keeps all three: the smallest coefficients that add up to the same.
  const auto ridge = ident::fit_ridge(data);
  CHECK(ridge.mean(0) + ridge.mean(3) == Approx(3.0).epsilon(0.01));
  CHECK(ridge.mean.cwiseAbs().maxCoeff() < 4.0);
  CHECK(ident::fit_lasso(data).mean.cwiseAbs().maxCoeff() < 4.0);
}

TEST_CASE("scaling a column by any factor scales its coefficient back", "[ident][degenerate]") {
  rc::prop("every draw", [] {
    const auto seed = *rc::gen::inRange(0u, 100000u);
    const MatrixXd phi = gaussian(200, 6, seed);
    const VectorXd target = 3.0 * phi.col(1) - phi.col(4) + 0.2 * gaussian(200, 1, seed + 1);
    MatrixXd scaled = phi;
    VectorXd factor(6);
    for (Index j = 0; j < 6; ++j) {
      factor(j) = (*rc::gen::inRange(1, 1000)) * std::pow(10.0, *rc::gen::inRange(-8, 8));
      scaled.col(j) *= factor(j);
    }
    const auto plain = all_fits(ident::r_factor(phi, target)), moved = all_fits(ident::r_factor(scaled, target));
    for (std::size_t k = 0; k < plain.size(); ++k) {
      RC_ASSERT(moved[k].relevant == plain[k].relevant);
      for (Index j = 0; j < plain[k].mean.size(); ++j) {
        const double back = moved[k].mean(j) * factor(plain[k].relevant[static_cast<std::size_t>(j)]);
        // Rounded columns; log alpha is settled to 1e-6 and moves a mean by less.
        RC_ASSERT(std::abs(back - plain[k].mean(j)) <= 1e-7 * plain[k].mean.cwiseAbs().maxCoeff());
      }
    }
  });
}
