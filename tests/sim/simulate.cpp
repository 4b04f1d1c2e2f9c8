#include "sim/simulate.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/systems.hpp"

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

TEST_CASE("the fastest sine that outputs resolve takes some twenty steps for each of them", "[sim][simulate]") {
  // A quarter of what free runs are allowed, whose tolerance this is.
  const auto run = sim::simulate(harmonic(2.0 * std::numbers::pi * 50.0), Eigen::Vector2d(1.0, 0.0),
                                 {.duration_s = 100.0,
                                  .sample_rate_hz = 100.0,
                                  .relative_tolerance = 1e-7,
                                  .absolute_tolerance = 1e-7,
                                  .max_steps_per_output = 25.0});
  CHECK(run.status == sim::SimulationStatus::finished);
}

TEST_CASE("a burst that the rest makes up for is no reason to end a run", "[sim][simulate]") {
  // Fast for two seconds of a hundred: 480 radians a second take some 1000 steps a second, the rest next to none.
  sim::System burst{.name = "burst", .states = {"x", "v"}, .rhs = [](double t, const double* y, int, double* dydt) {
                      const double w = t < 2.0 ? 480.0 : 0.01;
                      dydt[0] = y[1], dydt[1] = -w * w * y[0];
                    }};
  const sim::SimulateOptions options{.duration_s = 100.0, .sample_rate_hz = 1.0, .max_steps_per_output = 40.0};
  const auto run = sim::simulate(burst, Eigen::Vector2d(1.0, 0.0), options);
  CHECK(run.status == sim::SimulationStatus::finished);
  CHECK(run.num_steps > 500);
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

TEST_CASE("switches that fire in one instant are all passed", "[sim][simulate]") {
  // Two slopes of 1 that turn to -1 at 0.3: modes 0 to 3 by whether either has.
  sim::System s{.name = "twins", .states = {"x", "y"}, .rhs = [](double, const double*, int mode, double* dydt) {
                  dydt[0] = (mode & 1) != 0 ? -1.0 : 1.0;
                  dydt[1] = (mode & 2) != 0 ? -1.0 : 1.0;
                }};
  s.num_switches = 2;
  s.switching = [](double, const double* y, int mode, double* values) {
    for (int i = 0; i < 2; ++i) values[i] = (mode & (1 << i)) != 0 ? 1.0 : 0.3 - y[i];
  };
  s.next_mode = [](double, double*, int mode, int which) { return which < 0 ? 0 : mode | (1 << which); };
  const auto run = sim::simulate(s, Eigen::Vector2d::Zero(), {.duration_s = 1.0, .sample_rate_hz = 10.0});
  REQUIRE(run.events.size() == 2);
  CHECK(run.events[0].t_s == run.events[1].t_s);
  CHECK(run.events[1].mode_after == 3);
  CHECK(run.states(10, 0) == Approx(-0.4).margin(1e-12));
  CHECK(run.states(10, 1) == Approx(-0.4).margin(1e-12));
}

TEST_CASE("every reversal of a mass on a dry slide is where half its period ends", "[sim][simulate]") {
  // x'' = -k x - F sgn v: half cosines about F/k and -F/k in turn, each 2 F/k less wide, until the spring is too weak.
  const double k = 400.0, friction = 1.0, start = 0.0985, half_s = std::numbers::pi / std::sqrt(k);
  const auto e = sim::make_experiment(sim::Coulomb{.c = 0.0, .k = k, .c_f = friction, .force_n = 0.0, .x0 = start});
  for (const double tolerance : {1e-6, 1e-9, 1e-12}) {
    const auto run = sim::simulate(e.system, e.initial,
                                   {.duration_s = 4.0,
                                    .sample_rate_hz = 100.0,
                                    .relative_tolerance = tolerance,
                                    .absolute_tolerance = 0.01 * tolerance});
    REQUIRE(run.events.size() == 20);  // 0.0985 - 19 * 0.005 = 0.0035 still exceeds F/k, 0.0015 does not
    for (std::size_t n = 0; n < run.events.size(); ++n) {
      INFO("reversal " << n << " at " << tolerance);
      CHECK(run.events[n].t_s == Approx(static_cast<double>(n + 1) * half_s).margin(20.0 * tolerance));
    }
    CHECK(run.events.back().mode_after == 0);
    CHECK(run.states(400, 0) == Approx(start - 20 * 2.0 * friction / k).margin(20.0 * tolerance));
    // Within the fifth half period: which one it is tells the centre, the time since its start the angle.
    const double angle = std::sqrt(k) * (0.70 - 4.0 * half_s), centre = friction / k;
    CHECK(run.states(70, 0) ==
          Approx(centre + (start - 9.0 * friction / k) * std::cos(angle)).margin(20.0 * tolerance));
  }
}

TEST_CASE("errors follow the tolerance over all of its range", "[sim][simulate]") {
  const double omega = 7.0;
  for (double tolerance = 1e-3; tolerance > 1e-12; tolerance *= 0.1) {
    const auto run = sim::simulate(
        harmonic(omega), Eigen::Vector2d(1.0, 0.0),
        {.duration_s = 10.0, .sample_rate_hz = 97.0, .relative_tolerance = tolerance, .absolute_tolerance = tolerance});
    const double worst = (run.states.col(0).array() - (omega * run.time_s.array()).cos()).abs().maxCoeff();
    INFO(tolerance);
    CHECK(worst < 300.0 * tolerance);  // some hundred steps, each of which may err by as much
    CHECK(worst > 1e-4 * tolerance);   // and steps are not wasted
  }
}

TEST_CASE("a stiff system is handed to implicit formulas, through its switches too", "[sim][simulate]") {
  // Fast decay to a slow motion c + cos t, c stepping from 0 to 1 where the state passes 0.5.
  const double rate = 1e6;
  sim::System s{.name = "stiff", .states = {"x"}, .rhs = [=](double t, const double* y, int mode, double* dydt) {
                  dydt[0] = -rate * (y[0] - mode - std::cos(t)) - std::sin(t);
                }};
  s.num_switches = 1;
  s.switching = [](double, const double* y, int mode, double* values) { values[0] = mode == 0 ? y[0] - 0.5 : 1.0; };
  s.next_mode = [](double, double*, int, int which) { return which < 0 ? 0 : 1; };
  const auto run = sim::simulate(s, Eigen::VectorXd::Ones(1), {.duration_s = 10.0, .sample_rate_hz = 10.0});
  REQUIRE(run.status == sim::SimulationStatus::finished);
  REQUIRE(run.stiff_from_s);
  CHECK(*run.stiff_from_s < 1e-3);
  CHECK(run.num_steps < 10000);  // held to 6 / rate, explicit steps would be more than a million
  REQUIRE(run.events.size() == 1);
  CHECK(run.events[0].t_s == Approx(std::acos(0.5)).margin(1e-7));
  CHECK(run.states(5, 0) == Approx(std::cos(0.5)).margin(1e-8));
  CHECK(run.states(100, 0) == Approx(1.0 + std::cos(10.0)).margin(1e-8));
  CHECK_FALSE(sim::simulate(harmonic(100.0), Eigen::Vector2d(1.0, 0.0), {.duration_s = 5.0, .sample_rate_hz = 10.0})
                  .stiff_from_s);
}

TEST_CASE("the error of a simulation is estimated from above, and told where a motion multiplies it",
          "[sim][simulate]") {
  const sim::SimulateOptions options{.duration_s = 25.0, .sample_rate_hz = 100.0};
  sim::SimulateOptions exact = options;
  exact.relative_tolerance = 1e-13;
  exact.absolute_tolerance = 1e-15;
  std::vector<double> growth;
  for (const double ratio : {0.9, 1.3}) {
    const auto e = sim::make_experiment("duffing", {{"ratio", ratio}});
    const auto run = sim::simulate(e.system, e.initial, options), truth = sim::simulate(e.system, e.initial, exact);
    const auto error = sim::simulation_error(e.system, e.initial, options, run);
    const double worst = (run.states - truth.states).col(0).cwiseAbs().maxCoeff();
    const double size = std::sqrt(run.states.col(0).squaredNorm() / static_cast<double>(run.states.rows()));
    CHECK(error.relative[0] > worst / size);
    CHECK(error.relative[0] < 1000.0 * worst / size);  // errors go with the tolerance, give or take two powers of ten
    growth.push_back(error.growth);
  }
  CHECK(growth[0] > 1000.0 * growth[1]);  // what that record is known for
  const auto lost = sim::simulate(explosion(), Eigen::VectorXd::Ones(1), {.duration_s = 2.0, .sample_rate_hz = 10.0});
  CHECK(std::isinf(
      sim::simulation_error(explosion(), Eigen::VectorXd::Ones(1), {.duration_s = 2.0, .sample_rate_hz = 10.0}, lost)
          .growth));
}

TEST_CASE("a start without rates is said to be one", "[sim][simulate]") {
  sim::System s{
      .name = "pole", .states = {"x"}, .rhs = [](double, const double* y, int, double* dydt) { dydt[0] = 1.0 / y[0]; }};
  const auto run = sim::simulate(s, Eigen::VectorXd::Zero(1), {.duration_s = 1.0, .sample_rate_hz = 10.0});
  CHECK(run.status == sim::SimulationStatus::diverged);
  CHECK_THAT(run.reason, Contains("pole: no step is small enough at t = 0 s (the rates there are no numbers)"));
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
