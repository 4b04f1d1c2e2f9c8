#include "ident/validate/closed_orbit.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "dsp/prepare.hpp"
#include "ident/columns/columns.hpp"
#include "ident/equation/interval_95.hpp"
#include "ident/identify.hpp"
#include "ident/judgement/judge.hpp"
#include "support/labelled_oscillator.hpp"

using ident::Verdict;

namespace {

constexpr double k = 227.4, c = 0.36;

/// A mass of 1 kg that a shaker holds in the steady state of one sine, 30 s of it: transients have died away in 80 s,
/// to 1e-6.
dsp::Recording steady_sine(double cubic, double force_N, std::uint32_t seed, double noise = 2e-3) {
  support::Oscillator p;
  p.k = k, p.c = c, p.k3 = cubic, p.force_gain = 1.0, p.amplitude = 0.01, p.omega = std::sqrt(k);
  p.drive.tones = {{force_N, 2.0 * std::numbers::pi * 2.1, 0.1 * seed, 0.0}};
  dsp::Motion motion = support::motion_of(p, 110.0, 200.0);
  for (dsp::Signal& signal : motion.signals) signal.values = signal.values.tail(6000).eval();
  motion.signals.front().values.array() -= motion.signals.front().values(0);
  return support::recorded(motion, {"x", "f"}, noise, seed);
}

std::vector<ident::RangeResult> identified(const dsp::Recording& recording, ident::LibraryOptions library) {
  dsp::PrepareOptions prepare;
  prepare.cutoff_hz = 20.0;  // holds five odd harmonics: ten equations for twelve candidates
  return ident::identify(ident::find_regimes(dsp::prepare(recording, prepare)), library);
}

/// Every interval that is claimed holds the truth, or zero where there is no such term.
void check_covered(const ident::Model& model, const std::vector<std::pair<std::string, double>>& truth) {
  for (const ident::ModelTerm& term : model.terms) {
    double value = 0.0;
    for (const auto& [name, coefficient] : truth)
      if (name == term.name) value = coefficient;
    CAPTURE(term.name, term.mean, term.std, value);
    CHECK((std::isnan(term.std) || std::abs(term.mean - value) <= ident::interval_95 * term.std));
  }
}

}  // namespace

TEST_CASE("of a steady sine no verdict is above undecided, and what is claimed of a coefficient holds the truth",
          "[ident][orbit]") {
  const ident::LibraryOptions library{.order = 3, .terms = {"sgn(v)", "f"}};
  for (std::uint32_t seed = 1; seed <= 10; ++seed)
    for (const double cubic : {0.0, 2e5}) {
      const auto ranges = identified(steady_sine(cubic, 0.9, seed), library);
      for (const ident::RangeResult& range : ranges) {
        CAPTURE(seed, cubic, range.spec.name);
        REQUIRE(range.orbit.has_value());
        CHECK(range.orbit->hz == Approx(2.1).epsilon(1e-4));
        CHECK(range.orbit->num_lines >= 1);
        CHECK(range.orbit->num_equations() < range.orbit->num_candidates);
        for (const ident::JudgedFit& fit : range.fits) {
          if (fit.model.terms.empty()) continue;
          CAPTURE(fit.judgement.sentence);
          CHECK(ident::preference(fit.judgement.verdict) <= ident::preference(Verdict::undecided));
          check_covered(fit.model, {{"x", -k}, {"v", -c}, {"x^3", -cubic}, {"f", 1.0}});
        }
      }
    }
}

TEST_CASE("a record with as many equations as candidates is no closed orbit that matters", "[ident][orbit]") {
  // Ten lines of an orbit without noise, and three candidates.
  const auto few = identified(steady_sine(2e5, 0.9, 1, 1e-7), {.order = 0, .terms = {"x", "x^3", "f"}});
  CHECK_FALSE(few.front().orbit.has_value());
  // A second tone closes no orbit within the record.
  support::Oscillator p;
  p.k = k, p.c = c, p.force_gain = 1.0, p.amplitude = 0.01, p.omega = std::sqrt(k);
  p.drive.tones = {{0.9, 13.2, 0.0, 0.0}, {0.3, 17.9, 0.0, 0.0}};
  const auto two = support::recorded(support::motion_of(p, 60.0, 200.0), {"x", "f"}, 2e-3, 1);
  CHECK_FALSE(identified(two, {.order = 3, .terms = {"f"}}).front().orbit.has_value());
}

TEST_CASE("the intervals of an orbit hold every equation that fits its lines", "[ident][orbit]") {
  // Three lines, six equations: the target is column 0, and columns 1 and 2 together are column 0 as well.
  ident::ClosedOrbit orbit{.hz = 1.0, .num_lines = 3, .num_candidates = 7};
  orbit.equations = 100.0 * Eigen::MatrixXd::Identity(6, 8);
  orbit.equations.col(6).setZero();
  orbit.equations.col(1) << 50.0, 80.0, 0.0, 0.0, 0.0, 0.0;
  orbit.equations.col(2) << 50.0, -80.0, 0.0, 0.0, 0.0, 0.0;
  orbit.equations.col(6)(5) = 1e-3;
  orbit.equations.col(7) = 2.0 * orbit.equations.col(0);
  const auto stds = ident::stds_of_orbit(orbit, {0}, Eigen::VectorXd::Constant(1, 2.0));
  REQUIRE(stds.has_value());
  CHECK((*stds)(0) * ident::interval_95 >= 2.0);  // it may not be there at all
  orbit.equations.col(2) << 0.0, 0.0, 0.0, 0.0, 80.0, 80.0;
  const auto alone = ident::stds_of_orbit(orbit, {0}, Eigen::VectorXd::Constant(1, 2.0));
  REQUIRE(alone.has_value());
  CHECK((*alone)(0) < 0.1);  // no other column reaches the target
  orbit.num_lines = 2;
  orbit.equations.conservativeResize(4, 8);
  CHECK_FALSE(ident::stds_of_orbit(orbit, {0}, Eigen::VectorXd::Constant(1, 2.0)).has_value());
}
