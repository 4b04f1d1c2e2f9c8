#include "apps/identified_system.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "apps/paper/section4.hpp"
#include "ident/validate/metrics.hpp"
#include "sim/simulate.hpp"

using Eigen::Index;
using Eigen::VectorXd;

namespace {

// The true equations of a case in the terms of its library.
std::vector<apps::IdentifiedRow> true_rows(const apps::Section4Study& study) {
  std::vector<apps::IdentifiedRow> rows;
  for (const auto& regression : study.regressions)
    for (const auto& row : regression.rows) {
      apps::IdentifiedRow identified{row.row, row.where, {}, {}};
      std::vector<double> mean;
      for (Index i = 0; i < row.truth.size(); ++i)
        if (row.truth(i) != 0.0) identified.terms.push_back(i), mean.push_back(row.truth(i));
      identified.mean = Eigen::Map<const VectorXd>(mean.data(), static_cast<Index>(mean.size()));
      rows.push_back(std::move(identified));
    }
  return rows;
}

ident::CandidateLibrary library_of(const std::vector<std::string>& terms) {
  dsp::Motion motion;
  motion.sample_rate_hz = 1.0;
  for (const char* name : {"t", "x", "v", "f", "a"}) motion.signals.push_back({name, "", VectorXd::Zero(1)});
  return ident::make_library({.order = 0, .terms = terms}, "a", motion);
}

}  // namespace

TEST_CASE("the true equations in library terms run as the system itself", "[apps][identified_system]") {
  for (const char* name : {"coulomb", "bouc-wen", "valanis-4"}) {
    const auto& definition = *apps::find_section4_case(name);
    const auto study = apps::section4_study(definition);
    const auto record = apps::section4_record(definition, 1.05);
    const auto experiment = sim::make_experiment(definition.system, {{"ratio", 1.05}});
    const auto system =
        apps::identified_system(study.library, true_rows(study), experiment.system.states, experiment.system.forcing);
    const auto run = sim::simulate(system, experiment.initial, {.duration_s = 25.0, .sample_rate_hz = 100.0});
    REQUIRE(run.status == sim::SimulationStatus::finished);
    INFO(name);
    // |z| is not switched here, so its kinks cost a few digits.
    for (Index j = 0; j < run.states.cols(); ++j)
      CHECK(ident::nmse(run.states.col(j), record.simulation.states.col(j)) <= 1e-12);
  }
}

TEST_CASE("identified friction comes to rest and is let go again", "[apps][identified_system]") {
  // x'' = f - 100 x - 3 sgn(v): released from 0.1 at no force it loses 4 F / k = 0.12 a cycle and stops within 0.03.
  const auto library = library_of({"v", "f", "x", "sgn(v)"});
  const std::vector<apps::IdentifiedRow> rows{{1, "", {0}, VectorXd::Ones(1)},
                                              {2, "", {1, 2, 3}, VectorXd{{1.0, -100.0, -3.0}}}};
  const auto still = sim::simulate(apps::identified_system(library, rows, {"x", "v"}, [](double) { return 0.0; }),
                                   Eigen::Vector2d(0.1, 0.0), {.duration_s = 5.0, .sample_rate_hz = 100.0});
  REQUIRE(still.status == sim::SimulationStatus::finished);
  CHECK(still.modes.back() == 0);
  CHECK(still.states(still.states.rows() - 1, 0) == Approx(0.1 - 0.12).margin(1e-9));  // one full cycle's loss
  CHECK(still.states(still.states.rows() - 1, 1) == 0.0);
  const auto moved =
      sim::simulate(apps::identified_system(library, rows, {"x", "v"}, [](double t) { return t < 3.0 ? 0.0 : t; }),
                    Eigen::Vector2d(0.1, 0.0), {.duration_s = 5.0, .sample_rate_hz = 100.0});
  CHECK(moved.states(moved.states.rows() - 1, 0) > 0.0);
}

TEST_CASE("a switch on anything but the velocity is refused", "[apps][identified_system]") {
  const auto library = library_of({"sgn(x)", "v"});
  CHECK_THROWS_AS(
      apps::identified_system(library, {{2, "", {0}, VectorXd::Ones(1)}}, {"x", "v"}, [](double) { return 0.0; }),
      std::invalid_argument);
}
