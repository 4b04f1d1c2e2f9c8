#include "apps/paper/free_response.hpp"

#include <limits>
#include <memory>

#include "apps/process/interrupt.hpp"
#include "ident/validate/metrics.hpp"

namespace apps {
namespace {

constexpr double divergence_factor = 100.0;

std::vector<std::string> states_of(const sim::Experiment& experiment, const Section4Case& definition) {
  const auto& states = experiment.system.states;
  return {states.begin(), states.begin() + definition.num_rows};
}

sim::Experiment experiment_of(const Section4Case& definition, const Section4Record& record) {
  return sim::make_experiment(definition.system, {{"ratio", record.ratio}});
}

}  // namespace

sim::Simulation free_response(const Section4Case& definition, const std::vector<ident::StateEquation>& equations,
                              const Section4Record& record) {
  const sim::Experiment experiment = experiment_of(definition, record);
  const ident::EquationFrame frame{.states = states_of(experiment, definition), .inputs = {"f"}};
  const auto system = ident::system_of(std::make_shared<const ident::EquationOfMotion>(equations, frame),
                                       [forcing = experiment.system.forcing](double t, double* f) { *f = forcing(t); });
  const double rate_hz = record.motion.sample_rate_hz;
  return sim::simulate(
      system, experiment.initial.head(definition.num_rows),
      {.duration_s = static_cast<double>(record.motion.num_samples() - 1) / rate_hz,
       .sample_rate_hz = rate_hz,
       .relative_tolerance = 1e-8,
       .absolute_tolerance = 1e-10,
       .divergence_bound =
           divergence_factor * record.simulation.states.leftCols(definition.num_rows).cwiseAbs().maxCoeff(),
       .poll = check_interrupted});
}

std::vector<StateError> state_errors(const sim::Simulation& run, const Section4Case& definition,
                                     const Section4Record& record) {
  const bool finished = run.status == sim::SimulationStatus::finished;
  std::vector<StateError> errors;
  for (const std::string& state : states_of(experiment_of(definition, record), definition)) {
    const auto j = std::ssize(errors);
    errors.push_back({state, std::numeric_limits<double>::quiet_NaN(), "diverged: " + run.reason});
    if (finished) errors.back() = {state, ident::nmse(run.states.col(j), record.simulation.states.col(j)), "finished"};
  }
  return errors;
}

}  // namespace apps
