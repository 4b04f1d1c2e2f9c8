#include "ident/state_space/thin.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "ident/state_space/inputs.hpp"
#include "ident/state_space/records.hpp"

using namespace ident::state_space;
using Eigen::Index;
using support::estimate_of;

namespace {

double sine(double hz, double time_s) {
  return std::sin(2.0 * std::numbers::pi * hz * time_s + 0.3);
}

}  // namespace

TEST_CASE("an input between samples is what a band-limited signal is there", "[ident][state_space]") {
  constexpr double rate_hz = 100.0;
  constexpr Index n = 400;
  // Away from the ends: at a third of the rate a polynomial through six samples would lose a third of it.
  for (const double hz : {0.7, 12.0, 33.0}) {
    Eigen::MatrixXd samples(n, 1);
    for (Index k = 0; k < n; ++k) samples(k) = sine(hz, static_cast<double>(k) / rate_hz);
    const Inputs inputs(samples, n, rate_hz);
    double worst = 0.0, worst_rate = 0.0;
    for (const double fraction : {0.0, 0.2, 0.3, 0.5, 0.8, 8.0 / 9.0, 1.0}) {
      const Inputs::Place place(fraction);
      for (Index k = 40; k < n - 40; ++k) {
        double values[2], rates[2];
        inputs.at(k, place, values, rates, 1);
        const double time_s = (static_cast<double>(k) + fraction) / rate_hz, w = 2.0 * std::numbers::pi * hz;
        worst = std::max(worst, std::abs(values[0] - sine(hz, time_s)));
        worst_rate = std::max(worst_rate, std::abs(rates[0] / w - std::cos(w * time_s + 0.3)));
        CHECK(values[1] == Approx(time_s));
      }
    }
    CAPTURE(hz);
    CHECK(worst < (hz > 20.0 ? 2e-4 : 1e-6));
    CHECK(worst_rate < (hz > 20.0 ? 3e-3 : 2e-5));
  }
}

TEST_CASE("an input near an end of its record is a polynomial", "[ident][state_space]") {
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(40, 0.0, 39.0);
  const Eigen::MatrixXd cubic = 0.01 * t.array().cube() - 0.3 * t.array().square() + t.array() - 2.0;
  const Inputs inputs(cubic, 40, 1.0);
  for (const Index k : {0, 1, 20, 38, 39})
    for (const double fraction : {0.0, 0.25, 0.6, 1.0}) {
      double values[2];
      inputs.at(k, Inputs::Place(fraction), values, nullptr, 1);
      const double at = static_cast<double>(k) + fraction;
      CHECK(values[0] == Approx(((0.01 * at - 0.3) * at + 1.0) * at - 2.0).margin(1e-9));
    }
}

TEST_CASE("samples that show noise alone beside the motion may be left out", "[ident][state_space]") {
  // 25 s of 0.8 Hz at 400 Hz: the third harmonic ends at 3 Hz, and with it the motion under 1 % of noise.
  const support::Runs runs = support::runs_of(sim::Duffing{}, {0.9, 1.1}, 25.0, 400.0);
  const Problem problem = support::problem_of(runs, {"x", "v", "x^3", "f"}, "x", 0.01, 930010);
  const Index factor = thinning(problem);
  CHECK(factor >= 4);
  const Problem fewer = thinned(problem, factor);
  CHECK(fewer.sample_rate_hz == Approx(400.0 / static_cast<double>(factor)));
  CHECK(thinning(fewer) == 1);
  const Fit all = fit(problem, {}), thin = fit(fewer, {});
  REQUIRE(all.converged());
  REQUIRE(thin.converged());
  for (int i = 0; i < 4; ++i) {
    const auto [value, std] = estimate_of(all, i);
    const auto [value_thin, std_thin] = estimate_of(thin, i);
    CAPTURE(i, value, std, value_thin, std_thin);
    CHECK(std_thin == Approx(std).epsilon(0.1));  // but for what was beside either end
    CHECK(std::abs(value_thin - value) < 0.5 * std);
  }
}

TEST_CASE("no sample is left out of what has missing ones, is short, or moves up to the end of its band",
          "[ident][state_space]") {
  const support::Runs runs = support::runs_of(sim::Duffing{}, {1.0}, 25.0, 400.0);
  Problem problem = support::problem_of(runs, {"x", "v", "x^3", "f"}, "x", 0.01, 930011);
  CHECK(thinning(problem) > 1);
  Problem with_gap = problem;
  with_gap.records[0].channels(500, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK(thinning(with_gap) == 1);
  Problem is_short = problem;
  is_short.records[0].channels.conservativeResize(1500, Eigen::NoChange);
  is_short.records[0].inputs.conservativeResize(1500, Eigen::NoChange);
  CHECK(thinning(is_short) == 1);
  Problem fast = problem;
  for (Index k = 0; k < fast.records[0].channels.rows(); ++k)
    fast.records[0].channels(k, 0) += 0.1 * sine(150.0, static_cast<double>(k) / 400.0);
  CHECK(thinning(fast) == 1);
  CHECK(thinned(problem, 1).records[0].channels == problem.records[0].channels);
  CHECK_THROWS_AS(thinned(problem, 0), std::invalid_argument);
  Problem with_piece = problem;
  with_piece.records.push_back({problem.records[0].channels.topRows(32), problem.records[0].inputs.topRows(32)});
  CHECK(thinned(with_piece, 4).records.size() == 1);
}
