#include "ident/state_space/step.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/simulate.hpp"
#include "sim/systems.hpp"

using Eigen::Index;
using namespace ident::state_space;

namespace {

struct Run {
  Problem problem;
  std::vector<double> parameters;
  sim::Simulation truth;
};

/// A Coulomb oscillator and its force, as simulated.
Run coulomb(const sim::Coulomb& p, double duration_s, double rate_hz) {
  const sim::Experiment experiment = sim::make_experiment(p);
  Run run{{.equations = oscillator({"x", "v", "sgn(v)", "f"}, {"f"}), .channels = {{}}, .sample_rate_hz = rate_hz},
          {-p.k / p.m, -p.c / p.m, -p.c_f / p.m, p.force_n / p.m, 1.0, 0.0, 0.0, 0.0},
          sim::simulate(experiment.system, experiment.initial, {.duration_s = duration_s, .sample_rate_hz = rate_hz})};
  Eigen::MatrixXd force(run.truth.time_s.size(), 1);
  for (Index k = 0; k < force.rows(); ++k) force(k) = experiment.system.forcing(run.truth.time_s(k));
  run.problem.records = {{run.truth.states.col(0), force}};
  return run;
}

/// Largest difference between where the steps from every simulated state end and the next one, over the largest state.
Eigen::VectorXd worst_step(const Run& run, int parts) {
  const Model model(run.problem);
  const Record& record = run.problem.records.front();
  const Inputs inputs(record.inputs, record.inputs.rows(), run.problem.sample_rate_hz);
  Stepper stepper(model, {}, 1.0 / run.problem.sample_rate_hz, parts);
  Eigen::VectorXd worst = Eigen::VectorXd::Zero(2);
  for (Index k = 0; k + 1 < record.inputs.rows(); ++k) {
    const double from[2] = {run.truth.states(k, 0), run.truth.states(k, 1)};
    double to[2];
    stepper.take(inputs, k, 1, from, run.parameters, {{to, nullptr, nullptr}});
    for (Index i = 0; i < 2; ++i) worst(i) = std::max(worst(i), std::abs(to[i] - run.truth.states(k + 1, i)));
  }
  return worst.array() / run.truth.states.cwiseAbs().colwise().maxCoeff().transpose().array();
}

}  // namespace

TEST_CASE("steps through reversals of dry friction are those of a simulation", "[ident][state_space]") {
  const Run run = coulomb({.c_f = 10.0}, 4.0, 200.0);
  REQUIRE(run.truth.events.size() > 20);
  // The force between samples, a polynomial of fifth order, and the step itself: (omega h)^6 with omega h = 0.16.
  CHECK(worst_step(run, 2).maxCoeff() < 5e-7);
}

TEST_CASE("a motion that sticks is held until the force leads away", "[ident][state_space]") {
  // The force stays below the friction for much of each cycle.
  const Run run = coulomb({.m = 1.0, .c = 2.0, .k = 1000.0, .c_f = 60.0, .force_n = 100.0, .ratio = 0.3}, 4.0, 500.0);
  const auto stuck = (run.truth.states.col(1).array() == 0.0).count();
  REQUIRE(stuck > 200);
  // A release is noticed a part of a sample late: half of what the force gains in it moves the mass for so long.
  const double part_s = 1.0 / (500.0 * 8), late = 0.5 * 100.0 * 9.5 * part_s * part_s;
  CHECK(worst_step(run, 8)(1) < 2.0 * late / run.truth.states.col(1).cwiseAbs().maxCoeff());
}

TEST_CASE("twice as many steps a sample err by a thirty-second", "[ident][state_space]") {
  const Run run = coulomb({.c_f = 0.0}, 2.0, 40.0);  // omega h = 0.8
  Run smooth = run;
  smooth.problem.equations = oscillator({"x", "v"});
  smooth.parameters = {-1000.0, -2.0, 1.0, 0.0, 0.0, 0.0};
  smooth.problem.records.front().inputs.resize(run.problem.records.front().inputs.rows(), 0);
  const auto end = [&](int parts) {
    const Model model(smooth.problem);
    const Inputs inputs(smooth.problem.records.front().inputs, 8, 40.0);
    Stepper stepper(model, {}, 1.0 / 40.0, parts);
    const double from[2] = {1.0, 0.0};
    double to[2];
    stepper.take(inputs, 0, 1, from, smooth.parameters, {{to, nullptr, nullptr}});
    return to[0];
  };
  const double h = 1.0 / 40.0, omega = std::sqrt(1000.0 - 1.0),
               exact = std::exp(-h) * (std::cos(omega * h) + std::sin(omega * h) / omega);
  const double ratio = (end(2) - exact) / (end(4) - exact);
  CHECK(ratio == Approx(32.0).epsilon(0.25));  // the next order is omega h / 4 of it
}
