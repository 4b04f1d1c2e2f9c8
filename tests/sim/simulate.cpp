#include "sim/simulate.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

using Catch::Matchers::Contains;

namespace {

sim::System harmonic(double omega) {
  return {.name = "harmonic", .states = {"x", "v"}, .rhs = [=](double, const double* y, int, double* dydt) {
            dydt[0] = y[1];
            dydt[1] = -omega * omega * y[0];
          }};
}

/// x' = x^2 from 1 reaches infinity at t = 1.
sim::System explosion() {
  return {.name = "explosion", .states = {"x"}, .rhs = [](double, const double* y, int, double* dydt) {
            dydt[0] = y[0] * y[0];
          }};
}

/// Slope 1 up to x = 0.3, then -2.
sim::System kink() {
  sim::System s{.name = "kink", .states = {"x"}, .rhs = [](double, const double*, int mode, double* dydt) {
                  dydt[0] = mode == 0 ? 1.0 : -2.0;
                }};
  s.num_switches = 1;
  s.switching = [](double, const double* y, int mode, double* values) { values[0] = mode == 0 ? y[0] - 0.3 : 1.0; };
  s.next_mode = [](double, double*, int, int which) { return which < 0 ? 0 : 1; };
  return s;
}

}  // namespace

TEST_CASE("an undamped oscillator keeps to its cosine, states and exact derivatives alike", "[sim][simulate]") {
  const double omega = 7.0;
  const auto run =
      sim::simulate(harmonic(omega), Eigen::Vector2d(0.5, 0.0), {.duration_s = 10.0, .sample_rate_hz = 100.0});
  REQUIRE(run.status == sim::SimulationStatus::finished);
  REQUIRE(run.time_s.size() == 1001);
  CHECK(run.time_s[1000] == 10.0);
  const Eigen::ArrayXd phase = omega * run.time_s.array();
  // Local errors of 1e-10 a step add up over some thousand steps.
  CHECK((run.states.col(0).array() - 0.5 * phase.cos()).abs().maxCoeff() < 1e-7);
  CHECK((run.states.col(1).array() + 0.5 * omega * phase.sin()).abs().maxCoeff() < 1e-6);
  CHECK(run.derivatives.col(0) == run.states.col(1));
  CHECK((run.derivatives.col(1) + omega * omega * run.states.col(0)).norm() == 0.0);
}

TEST_CASE("outputs start where they are asked to", "[sim][simulate]") {
  const auto run = sim::simulate(harmonic(1.0), Eigen::Vector2d(1.0, 0.0),
                                 {.duration_s = 0.5, .sample_rate_hz = 10.0, .start_s = 3.0});
  REQUIRE(run.time_s.size() == 6);
  CHECK(run.time_s[0] == 3.0);
  CHECK(run.states(5, 0) == Approx(std::cos(0.5)).epsilon(1e-9));
}

TEST_CASE("a blow-up ends as a status with its time, and only finite samples are kept", "[sim][simulate]") {
  const auto run = sim::simulate(explosion(), Eigen::VectorXd::Ones(1), {.duration_s = 2.0, .sample_rate_hz = 1000.0});
  CHECK(run.status == sim::SimulationStatus::diverged);
  CHECK_THAT(run.reason, Contains("explosion: |x| passed 1e+06 at t = 0.99999"));
  REQUIRE(run.states.rows() == 1000);                         // t = 0 ... 0.999
  CHECK(run.states(999, 0) == Approx(1000.0).epsilon(1e-5));  // early errors grow with x^2
  CHECK(run.derivatives.rows() == 1000);
  CHECK(run.modes.size() == 1000);
}

TEST_CASE("a right-hand side that is not a number ends as a status too", "[sim][simulate]") {
  sim::System root{.name = "root", .states = {"x"}, .rhs = [](double, const double* y, int, double* dydt) {
                     dydt[0] = -std::sqrt(y[0]) - 1.0;
                   }};
  const auto run = sim::simulate(root, Eigen::VectorXd::Ones(1), {.duration_s = 5.0, .sample_rate_hz = 10.0});
  CHECK(run.status == sim::SimulationStatus::diverged);
  CHECK_THAT(run.reason, Contains("no step is small enough"));
  CHECK(run.states.allFinite());
}

TEST_CASE("too many steps between outputs end as a status", "[sim][simulate]") {
  const auto run = sim::simulate(harmonic(1e4), Eigen::Vector2d(1.0, 0.0),
                                 {.duration_s = 10.0, .sample_rate_hz = 1.0, .max_steps_per_output = 100});
  CHECK(run.status == sim::SimulationStatus::step_limit);
  CHECK_THAT(run.reason, Contains("more than 100 steps"));
  CHECK(run.states.rows() == 1);
}

TEST_CASE("a switch is located to rounding and the modes change there", "[sim][simulate]") {
  const auto run = sim::simulate(kink(), Eigen::VectorXd::Zero(1), {.duration_s = 1.0, .sample_rate_hz = 100.0});
  REQUIRE(run.events.size() == 1);
  CHECK(run.events[0].t_s == Approx(0.3).margin(1e-12));
  CHECK(run.events[0].mode_before == 0);
  CHECK(run.events[0].mode_after == 1);
  CHECK(run.modes[29] == 0);
  CHECK(run.modes[31] == 1);
  CHECK(run.states(100, 0) == Approx(0.3 - 2.0 * 0.7).margin(1e-12));
}

TEST_CASE("the integrator's states are continuous between and across its steps", "[sim][simulate]") {
  const double omega = 5.0;
  sim::Integrator integrator(harmonic(omega), Eigen::Vector2d(1.0, 0.0), {.duration_s = 3.0});
  double y[2], worst = 0.0;
  while (integrator.step())
    for (const double u : {0.0, 0.37, 1.0}) {
      const double t = integrator.begin_s() + u * (integrator.end_s() - integrator.begin_s());
      integrator.states(t, y);
      worst = std::max(worst, std::abs(y[0] - std::cos(omega * t)));
    }
  CHECK(integrator.end_s() == 3.0);
  CHECK(worst < 1e-7);
}

TEST_CASE("two runs give the same bits", "[sim][simulate]") {
  const sim::SimulateOptions options{.duration_s = 5.0, .sample_rate_hz = 50.0};
  const auto a = sim::simulate(harmonic(3.0), Eigen::Vector2d(1.0, 0.2), options);
  const auto b = sim::simulate(harmonic(3.0), Eigen::Vector2d(1.0, 0.2), options);
  CHECK(a.states == b.states);
}

TEST_CASE("nonsense is refused and a system's own exception comes through", "[sim][simulate]") {
  const Eigen::Vector2d start(1.0, 0.0);
  CHECK_THROWS_WITH(sim::simulate(harmonic(1.0), start, {.sample_rate_hz = 10.0}), Contains("duration_s"));
  CHECK_THROWS_WITH(sim::simulate(harmonic(1.0), start, {.duration_s = 1.0}), Contains("sample_rate_hz"));
  CHECK_THROWS_WITH(sim::simulate(harmonic(1.0), start, {.duration_s = 1.0, .sample_rate_hz = std::nan("")}),
                    Contains("sample_rate_hz"));
  CHECK_THROWS_WITH(sim::simulate(harmonic(1.0), Eigen::VectorXd::Ones(3), {.duration_s = 1.0, .sample_rate_hz = 1.0}),
                    Contains("2 states, got 3"));
  CHECK_THROWS_AS(
      sim::simulate(harmonic(1.0), Eigen::Vector2d(std::nan(""), 0.0), {.duration_s = 1.0, .sample_rate_hz = 1.0}),
      std::invalid_argument);
  sim::System broken{.name = "broken", .states = {"x"}, .rhs = [](double t, const double*, int, double* dydt) {
                       if (t > 0.5) throw std::domain_error("outside the record");
                       dydt[0] = 1.0;
                     }};
  CHECK_THROWS_WITH(sim::simulate(broken, Eigen::VectorXd::Zero(1), {.duration_s = 1.0, .sample_rate_hz = 10.0}),
                    "outside the record");
}
