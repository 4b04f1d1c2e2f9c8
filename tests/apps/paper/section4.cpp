#include "apps/paper/section4.hpp"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "apps/paper/comparison.hpp"
#include "ident/regression/multi_rvm.hpp"
#include "ident/validate/metrics.hpp"
#include "support/random.hpp"

namespace test_paper_section4 {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

const std::vector<std::string> six{"duffing", "bouc-wen", "valanis-1", "valanis-2", "valanis-3", "valanis-4"};

const apps::Section4Study& study(const std::string& name) {
  static std::map<std::string, apps::Section4Study> studies;  // simulated once for all the tests of one process
  auto found = studies.find(name);
  if (found == studies.end())
    found = studies.emplace(name, apps::section4_study(*apps::find_section4_case(name))).first;
  return found->second;
}

struct Tally {
  int exact = 0, covered = 0, coefficients = 0, converged = 0, fits = 0;
  double worst_error = 0.0;  // in posterior standard deviations
  std::map<std::string, int> exact_rows;
};

Tally tally(const std::string& name, double noise, std::uint64_t first_seed, int num_seeds) {
  Tally sum;
  for (int k = 0; k < num_seeds; ++k) {
    bool exact = true;
    for (const auto& regression : study(name).regressions) {
      const auto data = apps::section4_factor(study(name), regression, noise, first_seed + static_cast<unsigned>(k));
      for (std::size_t j = 0; j < regression.rows.size(); ++j) {
        const auto& row = regression.rows[j];
        const auto fit = ident::fit_fast_rvm(apps::row_factor(data, j));
        ++sum.fits;
        sum.converged += fit.status == ident::FitStatus::converged;
        if (!apps::support_error(fit, row.truth).exact()) {
          exact = false;
          continue;
        }
        ++sum.exact_rows[row.label()];
        for (std::size_t i = 0; i < fit.relevant.size(); ++i) {
          const auto index = static_cast<Index>(i);
          const double z = std::abs(fit.mean(index) - row.truth(fit.relevant[i])) /
                           std::sqrt(fit.interval_covariance()(index, index));
          sum.worst_error = std::max(sum.worst_error, z);
          sum.covered += z <= 1.959964;
          ++sum.coefficients;
        }
      }
    }
    sum.exact += exact;
  }
  return sum;
}

// Standard deviation of each coefficient of the true terms at this noise.
std::map<std::string, double> expected_stds(const apps::Section4Regression& regression, const apps::Section4Row& row,
                                            double noise, const apps::Section4Study& of) {
  std::vector<Index> kept;
  for (Index i = 0; i < row.truth.size(); ++i)
    if (row.truth(i) != 0.0) kept.push_back(i);
  // By the normal equations of unit-norm columns: another way than the product's, good to 1e-10 at condition 1e3.
  const MatrixXd columns = regression.phi(Eigen::all, kept);
  const VectorXd norm = columns.colwise().norm();
  const MatrixXd unit = columns * norm.cwiseInverse().asDiagonal();
  const MatrixXd inverse = (unit.transpose() * unit).inverse();
  std::map<std::string, double> se;
  for (std::size_t j = 0; j < kept.size(); ++j) {
    const auto index = static_cast<Index>(j);
    se[of.library.terms[static_cast<std::size_t>(kept[j])].name] =
        std::sqrt(inverse(index, index)) / norm(index) * noise * row.std;
  }
  return se;
}

}  // namespace

TEST_CASE("the libraries of Section 4 have as many terms as the paper counts", "[apps][section4][paper]") {
  const std::map<std::string, std::size_t> printed{{"duffing", 11},    {"coulomb", 8},    {"bouc-wen", 13},
                                                   {"bouc-wen-2", 12}, {"valanis-1", 13}, {"valanis-2", 14},
                                                   {"valanis-3", 14},  {"valanis-4", 12}};
  for (const auto& [name, count] : printed) {
    INFO(name);
    CHECK(study(name).library.terms.size() == count);
    CHECK(study(name).training.num_samples() ==
          2501 * static_cast<Index>(study(name).definition->training_ratios.size()));
  }
}

TEST_CASE("the true equations leave nothing of the noise-free targets", "[apps][section4][paper]") {
  for (const auto& definition : apps::section4_cases())
    for (const auto& regression : study(definition.name).regressions)
      for (const auto& row : regression.rows) {
        if (!row.truth_known) continue;
        INFO(definition.name << " row " << row.label());
        // At rest, the first sample of each record, sgn(v) is 0 and friction already what the coming motion needs.
        const auto& v = study(definition.name).training.at("v");
        VectorXd residual = regression.phi * row.truth - row.values;
        for (Index i = 0; i < residual.size(); ++i)
          if (v(regression.samples[static_cast<std::size_t>(i)]) == 0.0) residual(i) = 0.0;
        CHECK(residual.norm() <= 1e-10 * row.values.norm());  // rounding of sums of a dozen terms, and located zeros
      }
}

TEST_CASE("Valanis IV splits by the sign of the velocity into all its rows", "[apps][section4][paper]") {
  const auto& regressions = study("valanis-4").regressions;
  REQUIRE(regressions.size() == 3);
  CHECK(regressions[1].phi.rows() + regressions[2].phi.rows() == 17507);
  CHECK(std::abs(regressions[1].phi.rows() - 8881) <= 5);  // counted with another integrator
}

TEST_CASE("the support is exact in the six cases at 10 % noise", "[apps][section4][paper]") {
  int exact = 0, coefficients = 0, covered = 0;
  for (const auto& name : six) {
    INFO(name);
    const Tally t = tally(name, 0.10, 61000, 20);
    CHECK(t.exact >= 19);
    CHECK(t.converged == t.fits);
    CHECK(t.worst_error <= 5.0);
    exact += t.exact;
    covered += t.covered;
    coefficients += t.coefficients;
  }
  CHECK(exact >= 119);
  // 0.95 within four standard errors of that many draws.
  CHECK(std::abs(static_cast<double>(covered) / coefficients - 0.95) <= 4.0 * std::sqrt(0.95 * 0.05 / coefficients));
}

TEST_CASE("the support is exact at 1, 2 and 5 % noise", "[apps][section4][paper]") {
  for (const double noise : {0.01, 0.02, 0.05})
    for (const auto& name : six) {
      INFO(name << " at " << noise);
      CHECK(tally(name, noise, 62000, 20).exact >= 19);
    }
}

TEST_CASE("the support is exact in twenty moves down to no noise at all", "[apps][section4][paper]") {
  for (const double noise : {1e-2, 1e-4, 1e-6, 0.0})
    for (const char* name : {"duffing", "coulomb", "bouc-wen", "valanis-1", "valanis-2", "valanis-3", "valanis-4"})
      for (const auto& regression : study(name).regressions) {
        const auto data = apps::section4_factor(study(name), regression, noise, 62500);
        for (std::size_t j = 0; j < regression.rows.size(); ++j) {
          const auto fit = ident::fit_fast_rvm(apps::row_factor(data, j));
          INFO(name << " row " << regression.rows[j].label() << " noise " << noise << ": " << fit.iterations
                    << " moves");
          CHECK(fit.status == ident::FitStatus::converged);
          CHECK(apps::support_error(fit, regression.rows[j].truth).exact());
          CHECK(fit.iterations <= 20);
        }
      }
}

TEST_CASE("Valanis IV at 20 % noise is right as often as the likelihood can distinguish x v from v sin(x)",
          "[apps][section4][paper]") {
  // With the true term swapped for its neighbour, 2 log L changes by N(-D, 4 D) where D is the squared misfit of the
  // swapped library to the noise-free target in units of the noise: the swap wins with P(N(0, 1) > sqrt(D) / 2).
  const auto& of = study("valanis-4");
  const auto& regression = of.regressions[2];
  const auto& row = regression.rows.front();
  const auto index_of = [&](const char* name) {
    const auto& terms = of.library.terms;
    return std::find_if(terms.begin(), terms.end(), [&](const auto& term) { return term.name == name; }) -
           terms.begin();
  };
  REQUIRE(row.where == "v < 0");
  const std::vector<Index> swapped{index_of("v"), index_of("v*z"), index_of("v*sin(x)")};
  const auto fit = ident::fit_ols(ident::r_factor(regression.phi(Eigen::all, swapped), row.values));
  const double misfit = fit.noise_variance * static_cast<double>(regression.phi.rows() - 3);
  const double fraction = 0.5 * std::erfc(std::sqrt(misfit) / (0.20 * row.std) / std::sqrt(8.0));
  const int seeds = 300, exact = tally("valanis-4", 0.20, 63000, seeds).exact;
  INFO("theory " << 1.0 - fraction << ", found " << exact << " of " << seeds);
  CHECK(exact >= 0.8 * seeds);
  CHECK(std::abs(exact / static_cast<double>(seeds) - (1.0 - fraction)) <=
        4.0 * std::sqrt(fraction * (1.0 - fraction) / seeds));
}

TEST_CASE("95 % intervals cover over two hundred seeds", "[apps][section4][paper][slow]") {
  int coefficients = 0, covered = 0;
  for (const auto& name : six) {
    const Tally t = tally(name, 0.10, 64000, 200);
    covered += t.covered;
    coefficients += t.coefficients;
  }
  REQUIRE(coefficients > 8000);
  // Terms that may be there without being kept widen the intervals of those they resemble, here more than need be: none
  // is there. 0.972 was measured, with a standard error of 0.002.
  const double coverage = static_cast<double>(covered) / coefficients;
  CHECK(coverage >= 0.945);
  CHECK(coverage <= 0.98);
}

TEST_CASE("the interval of Coulomb's damping holds though its friction is lost in the noise",
          "[apps][section4][paper]") {
  const auto& of = study("coulomb");
  const auto& regression = of.regressions.front();
  const auto& row = regression.rows.at(1);
  const auto v = std::find_if(of.library.terms.begin(), of.library.terms.end(),
                              [](const auto& term) { return term.name == "v"; }) -
                 of.library.terms.begin();
  int kept = 0, covered = 0, covered_by_noise = 0;
  for (unsigned seed = 68000; seed < 68400; ++seed) {
    const auto fit = ident::fit_fast_rvm(apps::row_factor(apps::section4_factor(of, regression, 0.10, seed), 1));
    const auto at = std::find(fit.relevant.begin(), fit.relevant.end(), v);
    if (at == fit.relevant.end()) continue;
    const auto j = at - fit.relevant.begin();
    const double error = std::abs(fit.mean(j) - row.truth(v));
    ++kept;
    covered += error <= 1.96 * std::sqrt(fit.interval_covariance()(j, j));
    covered_by_noise += error <= 1.96 * std::sqrt(fit.covariance(j, j));
  }
  REQUIRE(kept == 400);
  // Where sgn(v) shows no sign of itself no interval can know of it; by the noise alone it is 0.56 to 0.65.
  CHECK(covered >= 0.84 * kept);
  CHECK(covered_by_noise < 0.70 * kept);
}

TEST_CASE("Coulomb's first row and its second row at little noise are exact", "[apps][section4][paper]") {
  CHECK(tally("coulomb", 0.10, 65000, 20).exact_rows["1"] == 20);
  for (const double noise : {0.01, 0.02}) CHECK(tally("coulomb", noise, 65000, 20).exact_rows["2"] == 20);
}

TEST_CASE("Coulomb's second row at 10 % is found as often as its information allows", "[apps][section4][paper]") {
  const auto& of = study("coulomb");
  const auto& regression = of.regressions.front();
  const auto& row = regression.rows.at(1);
  const double q = 3.84, tau = q - 1.0 - std::log(q);
  const double t = 1.0 / expected_stds(regression, row, 0.10, of).at("sgn(v)");
  // sgn(v) passes with P(|N(t, 1)| > sqrt q), each of the four false terms stays out with P(chi^2_1 < q).
  const auto normal = [](double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); };
  const double theory =
      (normal(t - std::sqrt(q)) + normal(-t - std::sqrt(q))) * std::pow(2.0 * normal(std::sqrt(q)) - 1.0, 4);
  int exact = 0;
  for (unsigned seed = 66000; seed < 66800; ++seed) {
    const auto data = apps::section4_factor(of, regression, 0.10, seed);
    exact += apps::support_error(ident::fit_fast_rvm(apps::row_factor(data, 1), {.tau = tau}), row.truth).exact();
  }
  // The product's own account of it, at the same threshold and at the best one.
  const auto weak = apps::weak_terms(of, 0.10, tau);
  REQUIRE(weak.size() == 1);
  CHECK(weak.front().term == "sgn(v)");
  CHECK(weak.front().t == Approx(t).epsilon(1e-8));
  CHECK(weak.front().kept_fraction == Approx(normal(t - std::sqrt(q)) + normal(-t - std::sqrt(q))).margin(0.01));
  CHECK(weak.front().best_exact_fraction == Approx(0.48).margin(0.02));
  INFO("t = " << t << ", theory " << theory << ", found " << exact << " of 800");
  CHECK(std::abs(exact / 800.0 - theory) <= 0.05);
}

TEST_CASE("slow and fast RVM give the same coefficients on the same support", "[apps][section4][paper]") {
  int compared = 0;
  for (const auto& name : six)
    for (unsigned seed = 67000; seed < 67010; ++seed)
      for (const auto& regression : study(name).regressions) {
        const auto data = apps::section4_factor(study(name), regression, 0.10, seed);
        for (std::size_t j = 0; j < regression.rows.size(); ++j) {
          const auto fast = ident::fit_fast_rvm(apps::row_factor(data, j)),
                     slow = ident::fit_slow_rvm(apps::row_factor(data, j));
          if (fast.relevant != slow.relevant) continue;
          ++compared;
          INFO(name << " row " << regression.rows[j].label() << " seed " << seed);
          CHECK((fast.mean - slow.mean).cwiseQuotient(fast.mean).cwiseAbs().maxCoeff() <= 1e-8);
        }
      }
  CHECK(compared >= 170);  // of 190
}

TEST_CASE("the multi-output fit keeps the union of the rows, its second stage each row's own terms",
          "[apps][section4][paper]") {
  for (const auto& name : six) {
    if (name == "valanis-4") continue;  // its rows do not share their samples
    const auto& regression = study(name).regressions.front();
    int shared_is_union = 0, exact = 0;
    for (unsigned seed = 69000; seed < 69020; ++seed) {
      const auto fit = ident::fit_multi_rvm(apps::section4_factor(study(name), regression, 0.10, seed));
      VectorXd any = VectorXd::Zero(regression.phi.cols());
      bool right = fit.rows.size() == regression.rows.size();
      for (std::size_t j = 0; right && j < regression.rows.size(); ++j) {
        any += regression.rows[j].truth.cwiseAbs();
        right = apps::support_error(fit.rows[j], regression.rows[j].truth).exact();
      }
      ident::Fit shared;
      shared.relevant = fit.relevant;
      shared_is_union += apps::support_error(shared, any).exact();
      exact += right;
    }
    INFO(name);
    CHECK(shared_is_union >= 19);
    CHECK(exact >= 19);
  }
}

TEST_CASE("predictive bands hold at ratios the fit has not seen", "[apps][section4][paper]") {
  for (const auto& name : {"duffing", "bouc-wen", "valanis-2"}) {
    const auto& of = study(name);
    const auto& regression = of.regressions.front();
    const auto data = apps::section4_factor(of, regression, 0.10, 70000);
    for (const double ratio : of.definition->held_out_ratios) {
      const auto record = apps::section4_record(*of.definition, ratio);
      for (std::size_t j = 0; j < regression.rows.size(); ++j) {
        const auto& row = regression.rows[j];
        const auto fit = ident::fit_fast_rvm(apps::row_factor(data, j));
        MatrixXd phi(record.motion.num_samples(), static_cast<Index>(fit.relevant.size()));
        for (std::size_t k = 0; k < fit.relevant.size(); ++k)
          phi.col(static_cast<Index>(k)) =
              of.library.terms[static_cast<std::size_t>(fit.relevant[k])].expression.evaluate(record.motion);
        const auto noise = support::gaussian(phi.rows(), 1, 7 + static_cast<unsigned>(100.0 * ratio));
        const auto fractions =
            ident::band_fractions(phi * fit.mean, ident::predictive_variance(phi, fit.covariance, fit.noise_variance),
                                  record.motion.at(row.target) + 0.10 * row.std * noise);
        INFO(name << " row " << row.label() << " ratio " << ratio);
        // 2501 rows: five standard errors.
        CHECK(fractions.within_50 == Approx(0.50).margin(0.05));
        CHECK(fractions.within_90 == Approx(0.90).margin(0.03));
        CHECK(fractions.within_95 == Approx(0.95).margin(0.022));
      }
    }
  }
}

TEST_CASE("type-II selection lets in as many false terms a row as the prototype counted", "[apps][section4][paper]") {
  int false_terms = 0, rows = 0;
  for (const auto& name : six)
    for (unsigned seed = 68000; seed < 68020; ++seed)
      for (const auto& regression : study(name).regressions) {
        const auto data = apps::section4_factor(study(name), regression, 0.10, seed);
        for (std::size_t j = 0; j < regression.rows.size(); ++j, ++rows)
          false_terms +=
              static_cast<int>(apps::support_error(ident::fit_fast_rvm(apps::row_factor(data, j),
                                                                       {.selection = ident::Selection::type2}),
                                                   regression.rows[j].truth)
                                   .false_terms.size());
      }
  const double per_row = static_cast<double>(false_terms) / rows;
  CHECK(per_row >= 0.8 * 1.3);  // 1.3 to 2.7 over its rows, 20 % either way
  CHECK(per_row <= 1.2 * 2.7);
}

TEST_CASE("the printed coefficients of variation of the slow RVM are those of our noise model",
          "[apps][section4][paper]") {
  int agree = 0, judged = 0, fast_agree = 0, fast_misprints = 0;
  for (const auto& paper : apps::printed_numbers()) {
    if (paper.table > 4 || paper.quantity != "cov") continue;
    const auto& definition = *std::find_if(apps::section4_cases().begin(), apps::section4_cases().end(),
                                           [&](const auto& known) { return known.table == paper.table; });
    const auto& of = study(definition.name);
    const auto& regression = of.regressions.front();
    const auto& row = regression.rows.at(static_cast<std::size_t>(std::stoi(paper.row) - 1));
    const double se = expected_stds(regression, row, 0.10, of).at(paper.term);
    const double mean = apps::printed_value(paper.table, paper.term, paper.method, "mean", paper.row);
    const bool slow = paper.method == "slow_rvm";
    // The fast RVM's lack the standard deviation of the noise.
    const double expected = apps::expected_cov(mean, se) / (slow ? 1.0 : 0.10 * row.std);
    INFO("table " << paper.table << " row " << paper.row << " " << paper.term << ": printed " << paper.value
                  << ", expected " << expected);
    const auto verdict = apps::verdict_on(paper, {.expected = expected, .expected_std = expected});
    judged += slow;
    (slow ? agree : fast_agree) += verdict == "within noise";
    if (slow)
      CHECK((verdict == "within noise" || (verdict == "misprint" && paper.table == 2 && paper.term == "x")));
    else
      fast_misprints += verdict == "misprint";
  }
  CHECK(judged == 17);
  CHECK(agree == 16);
  CHECK(fast_agree >= 12);
  CHECK(fast_agree + fast_misprints == 17);
}

TEST_CASE("a misprint is a power of ten or one digit away from what it should be", "[apps][section4][paper]") {
  int misprints = 0;
  for (const auto& paper : apps::printed_numbers()) {
    if (std::isnan(paper.should_be)) continue;
    ++misprints;
    INFO("table " << paper.table << " row " << paper.row << " " << paper.term << " " << paper.method);
    const double decades = std::log10(paper.value / paper.should_be);
    const bool power_of_ten = std::abs(decades - std::round(decades)) < 1e-9;
    const double unit = std::pow(10.0, std::floor(std::log10(paper.value)) - 1.0);  // of the last of two digits
    const long printed = std::lround(paper.value / unit), meant = std::lround(paper.should_be / unit);
    CHECK((power_of_ten || printed / 10 == meant / 10 || printed % 10 == meant % 10));
    CHECK_FALSE(paper.remark.empty());
  }
  CHECK(misprints == 5);
}

TEST_CASE("every printed term is a candidate of its case, and every number can be judged or says why not",
          "[apps][section4][paper]") {
  std::map<int, int> counts;
  for (const auto& paper : apps::printed_numbers()) {
    INFO("table " << paper.table << " row " << paper.row << " " << paper.term << " " << paper.method);
    ++counts[paper.table];
    CHECK(std::isfinite(paper.value));
    CHECK((paper.tolerance > 0.0 || !paper.remark.empty()));
    if (paper.table > 8 || paper.quantity == "seconds") continue;
    const auto& of =
        study(std::find_if(apps::section4_cases().begin(), apps::section4_cases().end(), [&](const auto& known) {
                return known.table == paper.table;
              })->name);
    CHECK(apps::column_of(of, paper.term) < static_cast<Index>(of.library.terms.size()));
  }
  CHECK(counts.size() == 12);
  CHECK(counts[9] == 18);  // three regimes and methods, train and test
}

}  // namespace test_paper_section4
