#include "sim/chain.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "sim/simulate.hpp"

namespace {

const sim::Chain chain{.masses = {1.0, 0.7, 1.3},
                       .links = {{.stiffness = 150.0},
                                 {.cubic = 1e4, .friction = 0.4},
                                 {.stiffness = 80.0, .damping = 0.2, .cubic = 8e3, .friction = 0.2}}};

/// Kinetic and elastic energy of a chain on a base that stands still.
double energy(const sim::Chain& of, const Eigen::VectorXd& y) {
  const auto n = static_cast<Eigen::Index>(of.masses.size());
  double sum = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const sim::Link& link = of.links[static_cast<std::size_t>(i)];
    const double d = y(i) - (i > 0 ? y(i - 1) : 0.0), v = y(n + i);
    sum += 0.5 * of.masses[static_cast<std::size_t>(i)] * v * v + 0.5 * link.stiffness * d * d +
           0.25 * link.cubic * d * d * d * d;
  }
  return sum;
}

}  // namespace

TEST_CASE("what a force puts into a chain is stored, damped or rubbed away", "[sim][chain]") {
  const sim::Drive drive = sim::random_drive(950001, 0.3, 4.0, 10.0);
  const sim::Experiment experiment = sim::make_experiment(chain, drive);
  const sim::Simulation run =
      sim::simulate(experiment.system, experiment.initial, {.duration_s = 20.0, .sample_rate_hz = 2000.0});
  REQUIRE(run.status == sim::SimulationStatus::finished);
  CHECK(run.events.size() > 50);
  const auto power = [&](Eigen::Index k) {
    const double f = drive.value(run.time_s(k));
    double sum = f * run.states(k, 3);
    for (Eigen::Index i = 0; i < 3; ++i) {
      const sim::Link& link = chain.links[static_cast<std::size_t>(i)];
      const double rate = run.states(k, 3 + i) - (i > 0 ? run.states(k, 2 + i) : 0.0);
      sum -= link.damping * rate * rate + link.friction * std::abs(rate);
    }
    return sum;
  };
  double work = 0.0, exchanged = 0.0;
  for (Eigen::Index k = 0; k + 1 < run.time_s.size(); ++k) {
    work += 0.5 * (power(k) + power(k + 1)) / 2000.0;
    exchanged += 0.5 * std::abs(power(k) + power(k + 1)) / 2000.0;
  }
  // The trapezium errs by (omega h)^2 / 12 of what is exchanged, omega h = 0.02.
  CHECK(std::abs(energy(chain, run.states.row(run.states.rows() - 1)) - work) < 1e-4 * exchanged);
}

TEST_CASE("strong friction holds masses together, and they are one", "[sim][chain]") {
  const sim::Chain pair{.masses = {1.0, 0.5}, .links = {{}, {.friction = 1e3}}}, one{.masses = {1.5}, .links = {{}}};
  const sim::Drive drive = sim::random_drive(950002, 0.3, 4.0, 10.0);
  const auto end = [&](const sim::Chain& of) {
    const sim::Experiment experiment = sim::make_experiment(of, drive);
    return sim::simulate(experiment.system, experiment.initial, {.duration_s = 5.0, .sample_rate_hz = 100.0}).states;
  };
  const Eigen::MatrixXd together = end(pair), alone = end(one);
  CHECK((together.col(0) - alone.col(0)).cwiseAbs().maxCoeff() < 1e-7 * alone.col(0).cwiseAbs().maxCoeff());
  CHECK((together.col(1) - together.col(0)).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("a chain on a moving base is one that an inertial force drives, in coordinates of the base", "[sim][chain]") {
  // Of one mass: m d'' = -k d - c d' - m r'', by its own integration of d.
  const sim::Drive drive = sim::random_drive(950003, 0.3, 3.0, 0.02);
  const sim::Chain on_base{.masses = {2.0}, .links = {{.cubic = 3e4}}, .base_driven = true};
  const sim::Chain forced{.masses = {2.0}, .links = {{.cubic = 3e4}}};
  const sim::Drive inertia{[&](double t) { return -2.0 * drive.acceleration(t); }, {}, {}};
  const auto run = [](const sim::Experiment& experiment) {
    return sim::simulate(experiment.system, experiment.initial, {.duration_s = 5.0, .sample_rate_hz = 100.0});
  };
  const sim::Simulation absolute = run(sim::make_experiment(on_base, drive)),
                        relative = run(sim::make_experiment(forced, inertia));
  for (Eigen::Index k = 0; k < absolute.time_s.size(); ++k)
    CHECK(absolute.states(k, 0) - drive.value(absolute.time_s(k)) == Approx(relative.states(k, 0)).margin(1e-9));
}

TEST_CASE("a drive has the derivatives that it says, and passes through its samples", "[sim][chain]") {
  const sim::Drive random = sim::random_drive(950004, 0.3, 4.0, 2.0);
  std::vector<double> samples;
  for (int k = 0; k < 400; ++k) samples.push_back(random.value(0.01 * k));
  const sim::Drive recorded = sim::recorded_drive(samples, 100.0);
  constexpr double h = 1e-5;
  for (const sim::Drive* one : {&random, &recorded})
    for (const double t : {0.5037, 1.2341, 2.718}) {
      CHECK(one->rate(t) == Approx((one->value(t + h) - one->value(t - h)) / (2 * h)).epsilon(1e-5));
      CHECK(one->acceleration(t) == Approx((one->rate(t + h) - one->rate(t - h)) / (2 * h)).epsilon(1e-5));
    }
  CHECK(recorded.value(1.23) == Approx(samples[123]).epsilon(1e-9));
  double square = 0.0;
  for (int k = 0; k < 100'000; ++k) square += std::pow(random.value(0.013 * k), 2) / 100'000;
  CHECK(std::sqrt(square) == Approx(2.0).epsilon(0.02));  // a thousand seconds of it
}

TEST_CASE("a chain is refused that is none", "[sim][chain]") {
  const sim::Drive drive = sim::random_drive(1, 0.3, 4.0, 1.0);
  CHECK_THROWS_AS(sim::make_chain({{"masses", 0}}), std::invalid_argument);
  CHECK_THROWS_AS(sim::make_chain({{"masses", 13}}), std::invalid_argument);
  CHECK_THROWS_AS(sim::make_chain({{"mass_3", 1}}), std::invalid_argument);
  CHECK_THROWS_AS(sim::make_chain({{"weight", 1}}), std::invalid_argument);
  CHECK_THROWS_AS(sim::make_experiment(sim::Chain{.masses = {1.0, -1.0}}, drive), std::invalid_argument);
  CHECK_THROWS_AS(sim::make_experiment(sim::Chain{.driven = 3}, drive), std::invalid_argument);
  const sim::Chain made = sim::make_chain({{"cubic_2", 5.0}, {"cubic", 7.0}, {"masses", 3}, {"mass_1", 2.0}});
  CHECK(made.masses == std::vector<double>{2.0, 1.0, 1.0});
  CHECK(made.links[1].cubic == 5.0);
  CHECK(made.links[2].cubic == 7.0);
}

TEST_CASE("a lagged drive is what the law of an actuator makes of a sine", "[sim][chain]") {
  constexpr double omega = 9.0, lag_s = 0.07;
  const sim::Drive sine{[](double t) { return std::sin(omega * t); }, {}, {}};
  const sim::Drive late = sim::lagged(sine, lag_s, 5.0);
  // From rest: the sine of steady state, and what starts it dies off.
  const double u = omega * lag_s;
  for (const double t : {0.0, 0.011, 0.4, 1.23456, 4.99}) {
    const double exact = (std::sin(omega * t) - u * std::cos(omega * t) + u * std::exp(-t / lag_s)) / (1.0 + u * u);
    // A straight line over a step h is off by (omega h)^2 / 8; a cubic at the very start has a kink to follow.
    CHECK(std::abs(late.value(t) - exact) < 5e-6);
  }
  CHECK_THROWS_AS(sim::lagged(sine, 0.0, 5.0), std::invalid_argument);
}
