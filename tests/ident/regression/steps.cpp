#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "ident/regression/fit.hpp"
#include "ident/regression/multi_rvm.hpp"
#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using support::gaussian;
using Support = std::vector<Index>;

namespace {

struct Case {
  const char* name;
  MatrixXd phi;
  VectorXd target;
};

// What a reader does with the steps: keeps a set, and finds an addition only of what is not in it, a removal only of
// what is.
Support replayed(const ident::Fit& fit) {
  Support kept;
  const auto add = [&](Index term) {
    CHECK(std::find(kept.begin(), kept.end(), term) == kept.end());
    kept.push_back(term);
  };
  const auto remove = [&](Index term) {
    const auto at = std::find(kept.begin(), kept.end(), term);
    REQUIRE(at != kept.end());
    kept.erase(at);
  };
  for (const ident::FitStep& step : fit.steps) switch (step.action) {
      case ident::FitAction::start:
        kept = step.terms;
        break;
      case ident::FitAction::add:
        add(step.term);
        break;
      case ident::FitAction::remove:
        remove(step.term);
        break;
      case ident::FitAction::exchange:
        remove(step.leaving);
        add(step.term);
        break;
      case ident::FitAction::reestimate:
        if (step.term >= 0) CHECK(std::find(kept.begin(), kept.end(), step.term) != kept.end());
        break;
    }
  std::sort(kept.begin(), kept.end());
  return kept;
}

VectorXd powers_sum(const MatrixXd& phi) {
  return phi * VectorXd{{1.0, 0.1, 0.01, 0.001, 0.0001, 0.00001}};
}

std::vector<Case> cases() {
  std::vector<Case> all;
  const MatrixXd plain = gaussian(300, 8, 1);
  all.push_back({"independent columns", plain, 2.0 * plain.col(2) - plain.col(5) + 0.3 * gaussian(300, 1, 2)});
  all.push_back({"noise alone", plain, gaussian(300, 1, 3)});
  const VectorXd x = VectorXd::LinSpaced(21, 0.0, 20.0);
  MatrixXd quintic(21, 6);
  for (Index j = 0; j < 6; ++j) quintic.col(j) = x.array().pow(static_cast<double>(j));
  all.push_back({"Wampler 2", quintic, powers_sum(quintic)});
  // Powers of an offset signal: the search exchanges terms, and starts from the full and the thinned model.
  const VectorXd offset = (gaussian(400, 1, 4).array() + 3.0).matrix();
  MatrixXd powers(400, 8);
  for (Index j = 0; j < 8; ++j) powers.col(j) = offset.array().pow(static_cast<double>(j));
  all.push_back({"powers of an offset signal", powers,
                 powers.col(1) - 0.3 * powers.col(3) + 0.01 * powers.col(6) + gaussian(400, 1, 5)});
  // The sum of two true terms draws the forward search to a third.
  MatrixXd decoy = gaussian(200, 6, 6);
  decoy.col(0) = decoy.col(3) + decoy.col(4) + 0.3 * gaussian(200, 1, 7);
  all.push_back({"a decoy", decoy, decoy.col(3) + decoy.col(4) + 0.2 * gaussian(200, 1, 8)});
  MatrixXd dependent = gaussian(100, 5, 9);
  dependent.col(3) = dependent.col(0) + dependent.col(1);
  all.push_back({"dependent columns", dependent, dependent.col(1) + 0.1 * gaussian(100, 1, 10)});
  return all;
}

}  // namespace

TEST_CASE("the steps of every method, replayed from their start, end at what was kept", "[ident][steps]") {
  for (const Case& one : cases()) {
    const auto data = ident::r_factor(one.phi, one.target);
    for (const ident::Fit& fit :
         {ident::fit_fast_rvm(data), ident::fit_fast_rvm(data, {.selection = ident::Selection::type2}),
          ident::fit_slow_rvm(data), ident::fit_multi_rvm(data).rows.front(), ident::fit_stlsq(data),
          ident::fit_lasso(data), ident::fit_lasso(data, {.lambda = 0.3}), ident::fit_ridge(data),
          ident::fit_ols(data)}) {
      INFO(one.name << ", " << ident::to_string(fit.method));
      REQUIRE_FALSE(fit.steps.empty());
      CHECK(fit.steps.front().action == ident::FitAction::start);
      CHECK(std::count_if(fit.steps.begin(), fit.steps.end(),
                          [](const auto& step) { return step.action == ident::FitAction::start; }) == 1);
      CHECK(replayed(fit) == fit.relevant);
      const bool has_evidence = std::isfinite(fit.log_evidence);
      for (const ident::FitStep& step : fit.steps) {
        CHECK(std::isfinite(step.log_evidence) == has_evidence);
        CHECK(step.noise_variance > 0.0);
        CHECK((step.leaving >= 0) == (step.action == ident::FitAction::exchange));
        const bool on_a_path = fit.method == ident::Method::lasso && step.action != ident::FitAction::start;
        if (!on_a_path || std::isfinite(step.penalty)) CHECK(std::isfinite(step.penalty) == on_a_path);
      }
      if (has_evidence) CHECK(fit.steps.back().log_evidence == Approx(fit.log_evidence).epsilon(1e-9));
    }
  }
}

TEST_CASE("the steps of a shared fit end at the shared terms", "[ident][steps]") {
  const MatrixXd phi = gaussian(300, 6, 20);
  MatrixXd targets(300, 2);
  targets << phi.col(1) + 0.2 * gaussian(300, 1, 21), phi.col(4) - phi.col(1) + 0.2 * gaussian(300, 1, 22);
  const auto fit = ident::fit_multi_rvm(ident::r_factor(phi, targets));
  ident::Fit shared;
  shared.steps = fit.steps;
  CHECK(replayed(shared) == fit.relevant);
  for (const ident::Fit& row : fit.rows) CHECK(replayed(row) == row.relevant);
}

TEST_CASE("an exchange names both terms and raises the evidence", "[ident][steps]") {
  // Columns 0 and 1 differ by a little w; column 2, which enters later, brings w along. Column 0 looks better as long
  // as column 2 is missing, and column 1 never gains enough beside it.
  int exchanges = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    MatrixXd phi = gaussian(200, 5, 40 + 3 * seed);
    const VectorXd w = gaussian(200, 1, 41 + 3 * seed);
    phi.col(0) = phi.col(1) + 0.1 * w;
    phi.col(2) = w + phi.col(4);
    const VectorXd target = phi.col(1) + 0.4 * phi.col(2) + 0.6 * gaussian(200, 1, 42 + 3 * seed);
    const auto fit = ident::fit_fast_rvm(ident::r_factor(phi, target));
    for (std::size_t i = 1; i < fit.steps.size(); ++i) {
      if (fit.steps[i].action != ident::FitAction::exchange) continue;
      ++exchanges;
      CHECK(fit.steps[i].leaving != fit.steps[i].term);
      CHECK(fit.steps[i].log_evidence > fit.steps[i - 1].log_evidence);
    }
  }
  INFO(exchanges << " exchanges");
  CHECK(exchanges > 0);
}

TEST_CASE("starts that were given up are counted apart", "[ident][steps]") {
  const VectorXd x = VectorXd::LinSpaced(21, 0.0, 20.0);
  MatrixXd phi(21, 6);
  for (Index j = 0; j < 6; ++j) phi.col(j) = x.array().pow(static_cast<double>(j));
  const auto fit = ident::fit_fast_rvm(ident::r_factor(phi, powers_sum(phi)));
  CHECK(fit.steps.front().terms == Support{0, 1, 2, 3, 4, 5});  // the full start won
  CHECK(fit.steps.size() == static_cast<std::size_t>(fit.iterations) + 1);
  CHECK(fit.discarded_iterations > 0);
}
