// What selection and intervals make of noise that is white, and of noise that is not.
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>

#include "ident/identify.hpp"
#include "support/oscillator.hpp"
#include "support/random.hpp"

namespace test_selection_coloured_noise {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

struct System {
  std::string name;
  dsp::Motion motion;  ///< exact
  ident::LibraryOptions library;
  std::map<std::string, double> truth;
};

System duffing() {
  return {"Duffing",
          support::motion_of(sim::make_experiment(sim::Duffing{}), 50.0, 50.0),
          {.order = 3, .terms = {"f"}},
          {{"x", -25.0}, {"v", -1.0}, {"x^3", -2500.0}, {"f", 100.0}}};
}

System coulomb() {
  return {"Coulomb",
          support::motion_of(sim::make_experiment(sim::Coulomb{}), 20.0, 125.0),
          {.order = 3, .terms = {"sgn(v)", "f"}},
          {{"x", -1000.0}, {"v", -2.0}, {"sgn(v)", -1.0}, {"f", 100.0}}};
}

VectorXd noise(Index count, double rho, unsigned seed) {
  VectorXd values = support::gaussian(count, 1, seed);
  for (Index i = 1; i < count; ++i) values(i) = rho * values(i - 1) + std::sqrt(1.0 - rho * rho) * values(i);
  return values;
}

struct Tally {
  int runs = 0, exact = 0, with_false = 0, false_terms = 0, missed_strong = 0, coefficients = 0, covered = 0,
      noise_covered = 0;
  double effective = 0.0, structural = 0.0;
};

/// |t| of each true term by generalised least squares on the true terms with rho and the noise known.
std::map<std::string, double> known_t(const System& system, double rho, double noise_std) {
  const ident::CandidateLibrary library = ident::make_library(system.library, "a", system.motion);
  const ident::Columns columns = ident::form_columns(library, "a", system.motion, system.name);
  MatrixXd phi(columns.phi.rows(), static_cast<Index>(system.truth.size()));
  std::vector<std::string> names;
  for (std::size_t j = 0; j < library.terms.size(); ++j)
    if (system.truth.count(library.terms[j].name) != 0) {
      phi.col(std::ssize(names)) = columns.phi.col(static_cast<Index>(j));
      names.push_back(library.terms[j].name);
    }
  MatrixXd white = phi;
  for (Index i = 1; i < phi.rows(); ++i)
    white.row(i) = (phi.row(i) - rho * phi.row(i - 1)) / std::sqrt(1.0 - rho * rho);
  const MatrixXd covariance = noise_std * noise_std * (white.transpose() * white).inverse();
  std::map<std::string, double> t;
  for (std::size_t j = 0; j < names.size(); ++j) {
    const auto index = static_cast<Index>(j);
    t[names[j]] = std::abs(system.truth.at(names[j])) / std::sqrt(covariance(index, index));
  }
  return t;
}

/// All of a motion by one method.
ident::JudgedFit fit_of(const System& system, const dsp::Motion& motion, const ident::FastRvmOptions& method) {
  const ident::CandidateLibrary library = ident::make_library(system.library, "a", motion);
  std::vector<ident::Columns> columns{ident::form_columns(library, "a", motion, system.name)};
  dsp::RangeSpec spec;
  spec.name = "all";
  spec.train_to_s = static_cast<double>(motion.num_samples()) / motion.sample_rate_hz;
  return ident::identify({spec, 1, {}}, columns, library, {.target = "a", .methods = {method}, .free_run = false})
      .fits.front();
}

Tally tally(const System& system, double fraction, double rho, unsigned first_seed, int runs, ident::Selection rule) {
  Tally result;
  for (int run = 0; run < runs; ++run) {
    dsp::Motion motion = system.motion;
    double noise_std = 0.0;
    for (dsp::Signal& signal : motion.signals)
      if (signal.name == "a") {
        noise_std = fraction * std::sqrt((signal.values.array() - signal.values.mean()).square().mean());
        signal.values += noise_std * noise(signal.values.size(), rho, first_seed + static_cast<unsigned>(run));
      }
    const ident::JudgedFit fit = fit_of(system, motion, {.selection = rule});
    const auto strong = known_t(system, rho, noise_std);
    ++result.runs;
    result.effective += fit.size.num_effective() / runs;
    result.structural += fit.size.structural_fraction / runs;
    int wrong = 0, missing = 0;
    std::map<std::string, bool> found;
    for (const ident::ModelTerm& term : fit.model.terms) {
      found[term.name] = true;
      if (system.truth.count(term.name) == 0) {
        ++wrong;
        continue;
      }
      ++result.coefficients;
      const double error = std::abs(term.mean - system.truth.at(term.name));
      result.covered += error <= 1.96 * term.std;
      result.noise_covered += error <= 1.96 * term.std_noise;
    }
    for (const auto& [name, value] : system.truth)
      if (!found[name]) {
        ++missing;
        if (strong.at(name) > 6.0) ++result.missed_strong;
      }
    result.false_terms += wrong;
    result.with_false += wrong > 0;
    result.exact += wrong == 0 && missing == 0;
  }
  return result;
}

void print(const char* what, double fraction, double rho, const char* rule, const Tally& t) {
  std::printf(
      "%-8s %4.1f %% rho %4.2f %-14s exact %2d/%d, with false terms %2d (%d terms), strong missed %d, covered %.3f "
      "(noise alone %.3f) of %d, n_eff %.0f, f %.3f\n",
      what, 100.0 * fraction, rho, rule, t.exact, t.runs, t.with_false, t.false_terms, t.missed_strong,
      static_cast<double>(t.covered) / t.coefficients, static_cast<double>(t.noise_covered) / t.coefficients,
      t.coefficients, t.effective, t.structural);
  std::fflush(stdout);
}

}  // namespace

TEST_CASE("coloured noise lets no false term in, and intervals cover", "[ident][selection]") {
  for (const double rho : {0.9, 0.99}) {
    const Tally found = tally(duffing(), 0.1, rho, 300, 10, ident::Selection::evidence);
    INFO("rho " << rho);
    CHECK(found.with_false <= 1);  // tau lets one in now and then: of forty records, two at most
    CHECK(found.missed_strong == 0);
    CHECK(found.covered >= 34);  // of 40: 38 are expected, and fewer than 34 in one of fifty
    CHECK(tally(duffing(), 0.1, rho, 300, 10, ident::Selection::evidence_white).with_false >= 2);
  }
}

TEST_CASE("where the residual is white all rows count, and the fit is that of the white rule", "[ident][selection]") {
  const Tally found = tally(duffing(), 0.1, 0.0, 400, 5, ident::Selection::evidence);
  const Tally white = tally(duffing(), 0.1, 0.0, 400, 5, ident::Selection::evidence_white);
  CHECK(found.exact == white.exact);
  CHECK(found.covered == white.covered);
  CHECK(found.effective > 0.95 * 2501);
}

TEST_CASE("misfit that is a function of the state counts once, however many rows show it", "[ident][selection]") {
  const System system = duffing();
  dsp::Motion motion = system.motion;
  const VectorXd &x = motion.at("x"), &v = motion.at("v");
  VectorXd misfit = (4.0 * x.array() / x.cwiseAbs().maxCoeff() + 3.0 * v.array() / v.cwiseAbs().maxCoeff()).sin();
  for (dsp::Signal& signal : motion.signals)
    if (signal.name == "a")
      signal.values += 0.03 * std::sqrt(signal.values.array().square().mean()) * misfit +
                       1e-3 * support::gaussian(signal.values.size(), 1, 5);
  const ident::JudgedFit fit = fit_of(system, motion, {}),
                         white = fit_of(system, motion, {.selection = ident::Selection::evidence_white});
  CHECK(fit.size.structural_fraction > 0.9);
  CHECK(fit.size.num_effective() < 60.0);  // of 2501 rows: the library and its probes span about thirty functions
  CHECK(fit.model.terms.size() < white.model.terms.size());
  std::size_t true_terms = 0;
  for (const ident::ModelTerm& term : fit.model.terms) {
    if (system.truth.count(term.name) == 0) continue;
    ++true_terms;
    INFO(term.name << " " << term.mean << " +- " << term.std);
    CHECK(std::abs(term.mean - system.truth.at(term.name)) < 3.0 * term.std);
  }
  CHECK(true_terms >= 3);
  CHECK(fit_of(system, motion, {.tau = 1e4}).model.terms.empty());  // the config's own threshold holds there too
}

TEST_CASE("supports and intervals at white and coloured noise", "[.study][selection]") {
  for (const System& system : {duffing(), coulomb()})
    for (const double rho : {0.0, 0.9, 0.99})
      for (const double fraction :
           system.name == "Duffing" ? std::vector<double>{0.01, 0.1, 0.3} : std::vector<double>{0.005, 0.02}) {
        const int runs = 40;
        print(system.name.c_str(), fraction, rho, "evidence",
              tally(system, fraction, rho, 7000, runs, ident::Selection::evidence));
        print(system.name.c_str(), fraction, rho, "evidence-white",
              tally(system, fraction, rho, 7000, runs, ident::Selection::evidence_white));
      }
}

TEST_CASE("what weighing the rows costs beside a fit that counts them in full", "[.study][selection_cost]") {
  struct Size {
    double rate_hz, duration_s;
    int order;
  };
  for (const Size& size : {Size{350.0, 50.0, 3}, Size{4000.0, 250.0, 4}})
    for (const double rho : {0.0, 0.9}) {
      System system = duffing();
      system.motion = support::motion_of(sim::make_experiment(sim::Duffing{}), size.duration_s, size.rate_hz);
      system.library.order = size.order;
      for (dsp::Signal& signal : system.motion.signals)
        if (signal.name == "a") signal.values += noise(signal.values.size(), rho, 9);
      const auto seconds = [&](ident::Selection rule) {
        const auto start = std::chrono::steady_clock::now();
        (void)fit_of(system, system.motion, {.selection = rule});
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      };
      const double white = seconds(ident::Selection::evidence_white), weighed = seconds(ident::Selection::evidence);
      std::printf("%lld rows x %zu, rho %.1f: %.3f s, counted in full %.3f s: %.1f times\n",
                  static_cast<long long>(system.motion.num_samples()),
                  ident::make_library(system.library, "a", system.motion).terms.size(), rho, weighed, white,
                  weighed / white);
      std::fflush(stdout);
    }
}

}  // namespace test_selection_coloured_noise
