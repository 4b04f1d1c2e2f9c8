#include "ident/bodies/system.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <limits>
#include <utility>

#include "ident/bodies/true_model.hpp"
#include "sim/chain.hpp"
#include "sim/ode/friction.hpp"
#include "sim/simulate.hpp"

namespace test_bodies_system {

namespace {

/// How many switches were ever held at once.
std::ptrdiff_t most_held(const sim::Simulation& run, int num_switches) {
  std::ptrdiff_t most = 0;
  std::array<double, sim::max_switches> sides{};
  for (const int mode : run.modes) {
    sim::sides_of(mode, num_switches, sides.data());
    most = std::max(most, std::count(sides.begin(), sides.begin() + num_switches, 0.0));
  }
  return most;
}

}  // namespace

TEST_CASE("equations of bodies move as the chain that they are those of, also where friction holds",
          "[ident][bodies][friction]") {
  const bool base_driven = GENERATE(false, true);
  const sim::Chain chain{.links = {{.friction = 0.6}, {.cubic = 1e4, .friction = 0.4}}, .base_driven = base_driven};
  const sim::Drive drive = sim::random_drive(960031, 0.3, 2.0, base_driven ? 0.008 : 1.5);
  const sim::Experiment experiment = sim::make_experiment(chain, drive);
  const sim::SimulateOptions options{.duration_s = 20.0, .sample_rate_hz = 100.0, .max_step_s = 0.01};
  const sim::Simulation truth = sim::simulate(experiment.system, experiment.initial, options);
  const sim::System system =
      ident::system_of(support::true_model(experiment, chain), [&](double t, double* values, double* rates) {
        values[0] = drive.value(t), rates[0] = drive.rate(t);
        if (base_driven) values[1] = drive.rate(t), rates[1] = drive.acceleration(t);
      });
  Eigen::VectorXd initial(4);
  initial << experiment.initial(0), experiment.initial(2), experiment.initial(1), experiment.initial(3);
  const sim::Simulation found = sim::simulate(system, initial, options);
  REQUIRE(truth.status == sim::SimulationStatus::finished);
  CAPTURE(found.reason);
  REQUIRE(found.status == sim::SimulationStatus::finished);
  CHECK(most_held(found, system.num_switches / 2) == 2);  // both bodies at rest
  for (Eigen::Index body = 0; body < 2; ++body) {
    const Eigen::VectorXd x = truth.states.col(body);
    // Tolerances of 1e-10 a step over some ten thousand of them.
    CHECK((found.states.col(2 * body) - x).cwiseAbs().maxCoeff() < 1e-6 * x.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("a switch that looks at an input whose rate is not known is passed", "[ident][bodies][friction]") {
  ident::BodiesModel model;
  model.layout = {1, ident::Frame::ground, {"f"}};
  model.terms = {{1, "x"}, {1, "sgn(v - f)"}};
  model.mean = Eigen::Vector2d(-1.0, -1.0);
  const sim::System system = ident::system_of(model, [](double t, double* values, double* rates) {
    values[0] = t < 1.0 ? -1.0 : 1.0, rates[0] = std::numeric_limits<double>::quiet_NaN();
  });
  const sim::Simulation run =
      sim::simulate(system, Eigen::Vector2d(0.0, 0.5), {.duration_s = 2.0, .sample_rate_hz = 10.0});
  REQUIRE(run.status == sim::SimulationStatus::finished);
  CHECK(std::count(run.modes.begin(), run.modes.end(), 0) == 0);
  CHECK(std::count(run.modes.begin(), run.modes.end(), run.modes.front()) < std::ssize(run.modes));  // it passed
}

}  // namespace test_bodies_system
