#include "ident/equation/response_draws.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

namespace test_ident_response_draws {

using ident::IdentifiedEquation;

namespace {

constexpr double calibration = 0.01;

/// Known coefficients, in lengths that a calibration left uncertain.
IdentifiedEquation known(std::vector<std::string> terms, const Eigen::VectorXd& mean) {
  IdentifiedEquation equation{.target = "a"};
  equation.terms = std::move(terms);
  equation.mean = mean;
  equation.covariance = Eigen::MatrixXd::Zero(mean.size(), mean.size());
  equation.base_measured = std::find(equation.terms.begin(), equation.terms.end(), "ddr") != equation.terms.end();
  equation.displacement_std = calibration;
  return equation;
}

ident::DrawnFigure jump_down(const ident::ResponseDraws& draws) {
  std::vector<double> hz;
  for (const sim::ResponseJumps& jumps : draws.located) hz.push_back(jumps.jump_down_rising_hz);
  return ident::drawn_figure(hz);
}

}  // namespace

TEST_CASE("a calibration that all lengths share moves amplitudes, and no jump of what was measured by it",
          "[response_draws]") {
  const IdentifiedEquation hardening = known({"x", "v", "x^3", "ddr"}, Eigen::Vector4d(-50.0, -0.8, -9.4e4, -1.0));
  const sim::FrequencyResponseOptions sweep{.from_hz = 0.9, .to_hz = 3.0, .step_hz = 0.1, .amplitude_m = 2e-3};
  constexpr int num_draws = 60;
  const auto measured = response_draws(hardening, sweep, {.num_draws = num_draws, .amplitude_measured = true});
  REQUIRE(jump_down(measured).fraction == 1.0);
  CHECK(jump_down(measured).std < 1e-12);
  const double standard_errors = 4.0 / std::sqrt(2.0 * num_draws);
  const ident::DrawnFigure peak = ident::drawn_figure(measured.peak_up_m);
  CHECK(peak.std == Approx(calibration * peak.mean).epsilon(standard_errors));
  const auto given = response_draws(hardening, sweep, {.num_draws = num_draws});
  CHECK(jump_down(given).std > 1e-3);
}

TEST_CASE("a linear answer to a length that is given does not depend on the calibration of lengths",
          "[response_draws]") {
  const sim::FrequencyResponseOptions sweep{.from_hz = 0.9, .to_hz = 1.3, .step_hz = 0.1, .amplitude_m = 2e-3};
  const IdentifiedEquation linear = known({"x", "v", "ddr"}, Eigen::Vector3d(-50.0, -0.8, -1.0));
  const auto of_base = response_draws(linear, sweep, {.num_draws = 8});
  for (const double std : of_base.up.x_std_m) CHECK(std < 1e-9);
  // x in wrong lengths per force: as far off as they are.
  const IdentifiedEquation forced = known({"x", "v", "f"}, Eigen::Vector3d(-50.0, -0.8, 1.0));
  const auto of_force = response_draws(forced, sweep, {.num_draws = 60});
  const ident::DrawnFigure peak = ident::drawn_figure(of_force.peak_up_m);
  CHECK(peak.std == Approx(calibration * peak.mean).epsilon(4.0 / std::sqrt(120.0)));
}

TEST_CASE("a drive and a static friction that are both given do not depend on the calibration", "[response_draws]") {
  IdentifiedEquation sliding = known({"x", "v", "sgn(v)", "ddr"}, Eigen::Vector4d(-50.0, -0.8, -0.08, -1.0));
  sliding.displacement_std = 0.0;
  const sim::FrequencyResponseOptions sweep{.from_hz = 0.5, .to_hz = 1.9, .step_hz = 0.1, .amplitude_m = 4.5e-3};
  const ident::DrawOptions given{.num_draws = 8, .static_friction = 0.385};
  const double sure = response_draws(sliding, sweep, given).located.front().unlock_rising_hz;
  REQUIRE(sure > 0.5);
  sliding.displacement_std = calibration;
  for (const sim::ResponseJumps& jumps : response_draws(sliding, sweep, given).located)
    CHECK(std::abs(jumps.unlock_rising_hz - sure) < 2e-5);  // located to 1e-5
}

}  // namespace test_ident_response_draws
