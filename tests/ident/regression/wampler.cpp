// Wampler's first two problems: exact quintics on x = 0 .. 20, whose columns are nearly dependent.
#include <catch2/catch.hpp>
#include <cmath>

#include "ident/regression/fit.hpp"
#include "ident/regression/multi_rvm.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

struct Wampler {
  MatrixXd phi;
  VectorXd truth, target;
};

Wampler wampler(int problem) {
  const VectorXd x = VectorXd::LinSpaced(21, 0.0, 20.0);
  Wampler w{MatrixXd(21, 6), VectorXd(6), {}};
  for (Index j = 0; j < 6; ++j) {
    w.phi.col(j) = x.array().pow(static_cast<double>(j));
    w.truth(j) = problem == 1 ? 1.0 : std::pow(0.1, static_cast<double>(j));
  }
  w.target = w.phi * w.truth;
  return w;
}

}  // namespace

TEST_CASE("an exact quintic is found whole by every Bayesian method and by thresholded least squares",
          "[ident][wampler]") {
  for (const int problem : {1, 2}) {
    const Wampler w = wampler(problem);
    const auto data = ident::r_factor(w.phi, w.target);
    for (const ident::Fit& fit :
         {ident::fit_fast_rvm(data), ident::fit_slow_rvm(data), ident::fit_multi_rvm(data).rows.front(),
          ident::fit_stlsq(data, {.threshold = 1e-8}), ident::fit_ols(data)}) {
      INFO("Wampler " << problem << ", " << ident::to_string(fit.method) << " " << fit.iterations);
      CHECK(fit.status == ident::FitStatus::converged);
      REQUIRE(fit.relevant.size() == 6);
      if (fit.method != ident::Method::slow_rvm) CHECK(fit.iterations <= 20);
      // Condition 4e4 at unit norm; x^5 weighs the constant down by another 3e6 in Wampler 1.
      for (Index j = 0; j < 6; ++j)
        CHECK(std::abs(fit.mean(j) - w.truth(j)) <= (problem == 1 ? 1e-7 : 1e-11) * w.truth(j));
      CHECK(std::isfinite(fit.noise_variance));
      CHECK(fit.covariance.allFinite());
    }
  }
}

TEST_CASE("a threshold and a lasso that drop terms of an exact quintic still end", "[ident][wampler]") {
  for (const int problem : {1, 2}) {
    const auto data = ident::r_factor(wampler(problem).phi, wampler(problem).target);
    for (const ident::Fit& fit : {ident::fit_stlsq(data), ident::fit_lasso(data)}) {
      INFO("Wampler " << problem << ", " << ident::to_string(fit.method) << " kept " << fit.relevant.size());
      // Coordinate by coordinate, columns of condition 4e4 take more sweeps than are worth their time.
      CHECK(fit.status ==
            (fit.method == ident::Method::lasso ? ident::FitStatus::iteration_limit : ident::FitStatus::converged));
      CHECK_FALSE(fit.relevant.empty());
      CHECK(fit.mean.allFinite());
      CHECK(fit.noise_variance >= 0.0);
    }
  }
}
