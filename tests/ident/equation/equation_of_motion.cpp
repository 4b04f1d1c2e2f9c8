#include "ident/equation/equation_of_motion.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "dsp/values/fault.hpp"
#include "ident/judgement/judge.hpp"
#include "sim/simulate.hpp"
#include "sim/systems.hpp"

namespace {

using Force = std::function<double(double)>;

sim::System system_with(const std::vector<ident::StateEquation>& equations, std::vector<std::string> states,
                        const Force& force) {
  const ident::EquationFrame frame{.states = std::move(states), .inputs = {"f"}};
  return ident::system_of(std::make_shared<const ident::EquationOfMotion>(equations, frame),
                          [force](double t, double* f) { *f = force(t); });
}

/// A system's true equations in candidate terms.
std::vector<ident::StateEquation> true_equations(const sim::Experiment& experiment) {
  std::vector<ident::StateEquation> equations;
  for (const sim::TrueTerm& term : experiment.truth)
    equations.push_back({static_cast<std::size_t>(term.row - 1), {term.name}, {term.value}, term.where});
  return equations;
}

}  // namespace

TEST_CASE("the true equations in candidate terms run as the system itself", "[ident][equation_of_motion]") {
  for (const char* name : {"coulomb", "bouc-wen", "valanis-4"}) {
    const auto experiment = sim::make_experiment(name, {{"ratio", 1.05}});
    const auto system = system_with(true_equations(experiment), experiment.system.states, experiment.system.forcing);
    const sim::SimulateOptions options{.duration_s = 25.0, .sample_rate_hz = 100.0};
    const auto run = sim::simulate(system, experiment.initial, options);
    const auto truth = sim::simulate(experiment.system, experiment.initial, options);
    REQUIRE(run.status == sim::SimulationStatus::finished);
    INFO(name);
    // |z| is not switched here, so its kinks cost a few digits.
    for (Eigen::Index j = 0; j < run.states.cols(); ++j)
      CHECK(ident::nmse(run.states.col(j), truth.states.col(j)) <= 1e-12);
  }
}

TEST_CASE("identified friction comes to rest and is let go again", "[ident][equation_of_motion]") {
  // x'' = f - 100 x - 3 sgn(v): released from 0.1 at no force it loses 4 F / k = 0.12 a cycle and stops within 0.03.
  const std::vector<ident::StateEquation> equations{{0, {"v"}, {1.0}}, {1, {"f", "x", "sgn(v)"}, {1.0, -100.0, -3.0}}};
  const Eigen::Vector2d initial(0.1, 0.0);
  const auto still = sim::simulate(system_with(equations, {"x", "v"}, [](double) { return 0.0; }), initial,
                                   {.duration_s = 5.0, .sample_rate_hz = 100.0});
  REQUIRE(still.status == sim::SimulationStatus::finished);
  CHECK(still.modes.back() == 0);
  CHECK(still.states(still.states.rows() - 1, 0) == Approx(0.1 - 0.12).margin(1e-9));  // one full cycle's loss
  CHECK(still.states(still.states.rows() - 1, 1) == 0.0);
  const auto moved = sim::simulate(system_with(equations, {"x", "v"}, [](double t) { return t < 3.0 ? 0.0 : t; }),
                                   initial, {.duration_s = 5.0, .sample_rate_hz = 100.0});
  CHECK(moved.states(moved.states.rows() - 1, 0) > 0.0);
}

TEST_CASE("scales of the states do not change the motion", "[ident][equation_of_motion]") {
  const std::vector<ident::StateEquation> equations{{1, {"f", "x", "sgn(v)"}, {1.0, -100.0, -3.0}}};
  const auto equation =
      std::make_shared<const ident::EquationOfMotion>(equations, ident::EquationFrame{.inputs = {"f"}});
  const auto force = [](double t, double* f) { *f = 20.0 * std::cos(5.0 * t); };
  const sim::SimulateOptions options{.duration_s = 5.0, .sample_rate_hz = 100.0};
  const auto plain = sim::simulate(ident::system_of(equation, force), Eigen::Vector2d(0.1, 0.0), options);
  const auto scaled =
      sim::simulate(ident::system_of(equation, force, {1e-3, 1e2}), Eigen::Vector2d(100.0, 0.0), options);
  // Both are integrated to 1e-10 of their own scales.
  CHECK((scaled.states.col(0) * 1e-3 - plain.states.col(0)).cwiseAbs().maxCoeff() < 1e-8);
}

TEST_CASE("a switch that is no velocity is passed and holds nothing", "[ident][equation_of_motion]") {
  // x'' = -9 sgn(x) from 1: a quarter of its period is sqrt(2 / 9).
  const auto system = system_with({{1, {"sgn(x)"}, {-9.0}}}, {"x", "v"}, [](double) { return 0.0; });
  const double period_s = 4.0 * std::sqrt(2.0 / 9.0);
  const auto run = sim::simulate(system, Eigen::Vector2d(1.0, 0.0),
                                 {.duration_s = 3.0 * period_s, .sample_rate_hz = 1.0 / period_s});
  REQUIRE(run.events.size() == 6);
  CHECK(run.events.front().t_s == Approx(0.25 * period_s).epsilon(1e-9));
  CHECK(run.states(3, 0) == Approx(1.0).epsilon(1e-8));
}

TEST_CASE("the motion of payload and base follow from either coordinate", "[ident][equation_of_motion]") {
  const std::map<std::string, double> base_motion{{"r", 0.3}, {"dr", 0.5}, {"ddr", 0.7}};
  const std::vector<std::string> base{"r", "dr", "ddr"}, terms{"r", "dr", "ddr", "x", "v", "y", "dy", "sgn(v)"};
  const std::vector<double> coefficients{0.0, 0.0, 0.0, 1.0, 10.0, 100.0, 1000.0, 0.0};
  const double sides[] = {1.0};
  const auto at = [&](std::vector<std::string> states, double position, double speed) {
    const ident::EquationOfMotion equation(
        {{1, terms, coefficients}}, {.states = std::move(states), .inputs = base, .base_moves = true, .offset_m = 0.1});
    std::vector<double> inputs;
    for (const std::string& name : equation.inputs()) inputs.push_back(base_motion.at(name));
    const double motion[] = {position, speed};
    return equation.acceleration({0.0, motion, inputs.data()}, sides);
  };
  // x = 2, v = 3: y = x + r + 0.1 = 2.4, dy = v + dr = 3.5
  CHECK(at({"x", "v"}, 2.0, 3.0) == Approx(2.0 + 30.0 + 240.0 + 3500.0));
  CHECK(at({"y", "dy"}, 2.4, 3.5) == Approx(2.0 + 30.0 + 240.0 + 3500.0));
}

TEST_CASE("equations that are not to be followed are refused", "[ident][equation_of_motion]") {
  const auto make = [](const std::vector<ident::StateEquation>& equations) {
    (void)ident::EquationOfMotion(equations, {.inputs = {"f"}});
  };
  CHECK_THROWS_AS(make({{1, {"z"}, {1.0}}}), dsp::Fault);
  CHECK_THROWS_AS(make({{1, {"x"}, {1.0}, "x > 0"}}), dsp::Fault);
  CHECK_THROWS_AS(make({{2, {"x"}, {1.0}}}), std::invalid_argument);
  CHECK_THROWS_AS(make({{1, {"x"}, {}}}), std::invalid_argument);
  CHECK_THROWS_AS(ident::EquationOfMotion({{1, {"x"}, {1.0}}}, {.states = {"x"}}), std::invalid_argument);
}
