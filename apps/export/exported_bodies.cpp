#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "apps/export/exported_equation.hpp"
#include "apps/export/prepared_rows.hpp"
#include "apps/output/bodies_file.hpp"
#include "apps/process/printable.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/fault.hpp"
#include "ident/bodies/statement.hpp"
#include "ident/bodies/system.hpp"
#include "ident/library/expression.hpp"
#include "ident/switches/interpolant.hpp"
#include "sim/simulate.hpp"

namespace apps {
namespace {

using Eigen::Index;
namespace fs = std::filesystem;

/// The g of every sgn(g), in order of first appearance.
std::vector<std::string> switches_of(const ident::BodiesModel& model) {
  std::vector<std::string> switches;
  for (const ident::BodyTerm& term : model.terms) {
    const ident::Expression expression(term.name);
    for (const std::string& g : expression.switches())
      if (std::find(switches.begin(), switches.end(), g) == switches.end()) switches.push_back(g);
  }
  return switches;
}

void describe_bodies(const FinishedBodies& found, ExportedEquation& result) {
  const ident::BodiesLayout& layout = found.model.layout;
  for (int body = 1; body <= layout.num_bodies; ++body) {
    result.states.push_back(layout.named('x', body)), result.states.push_back(layout.named('v', body));
    result.displacements.push_back(layout.named('x', body));
    result.driven.push_back(static_cast<std::size_t>(2 * body - 1));
  }
  if (layout.inner != ident::Inner::none)
    result.driven.push_back(result.states.size()), result.states.emplace_back("z");
  result.inputs = layout.inputs;
  result.switches = switches_of(found.model);
  describe_terms(result, std::vector<unsigned char>(result.switches.size(), 1));
}

/// Where the displacements of a recording are zero, of those that are not zero where the channel is.
void take_coordinates(const FinishedBodies& found, std::size_t recording, ExportedEquation& result) {
  std::vector<std::string> zeros;
  for (std::size_t i = 0; i < found.zeros[recording].size(); ++i) {
    const double zero = found.zeros[recording][i];
    if (zero == 0.0) continue;
    result.coordinates.push_back(
        {.recording = found.recordings[recording], .of = result.displacements[i], .unit = found.length, .zero = zero});
    zeros.push_back(fmt::format("{} is 0 where {:.9g} {} was recorded", result.displacements[i], zero, found.length));
  }
  if (!zeros.empty()) result.coordinates_sentence = fmt::format("{}.", fmt::join(zeros, "; "));
}

/// Its inputs, and where it begins: what the run's own free run goes through.
struct BodiesCourse {
  dsp::Motion motion;
  dsp::IndexRange samples;
  std::vector<double> state;
};

/// In steps so small that two integrators agree.
ExportedRun run_bodies_again(const FinishedBodies& found, const BodiesCourse& course,
                             const ExportedEquation& equation) {
  const ident::BodiesLayout& layout = found.model.layout;
  const double rate_hz = course.motion.sample_rate_hz;
  std::vector<ident::Interpolant> inputs;
  for (const std::string& name : equation.inputs)
    inputs.emplace_back(course.motion.at(name), rate_hz, course.samples.first, course.samples.last);
  const auto place = [&](const std::string& name) {
    return std::find(equation.inputs.begin(), equation.inputs.end(), name) - equation.inputs.begin();
  };
  const auto dr = place("dr"), ddr = place("ddr"), none = std::ssize(equation.inputs);
  const auto inputs_at = [&](double t, double* values, double* rates) {
    for (std::size_t i = 0; i < layout.inputs.size(); ++i) {
      const auto rate = layout.inputs[i] == "r" ? dr : layout.inputs[i] == "dr" ? ddr : none;
      values[i] = inputs[i].at(t);
      rates[i] = rate == none ? dsp::nan : inputs[static_cast<std::size_t>(rate)].at(t);
    }
  };
  sim::System system = ident::system_of(found.model, inputs_at);
  double scale = 0.0;  // of displacements; speeds and forces are no smaller in the units of a second
  for (const std::string& name : equation.displacements)
    for (const double x :
         course.motion.at(name).segment(course.samples.first, course.samples.last - course.samples.first))
      if (std::isfinite(x)) scale = std::max(scale, std::abs(x));
  system.scales.assign(equation.states.size(), scale > 0.0 ? scale : 1.0);
  ExportedRun result = run_over(course.motion, course.samples, equation.inputs);
  result.state = course.state;
  const sim::Simulation run =
      sim::simulate(system, Eigen::VectorXd::Map(course.state.data(), std::ssize(course.state)),
                    {.duration_s = static_cast<double>(course.samples.last - course.samples.first - 1) / rate_hz,
                     .sample_rate_hz = rate_hz,
                     .start_s = result.start_s,
                     .relative_tolerance = 1e-12,
                     .absolute_tolerance = 1e-12,
                     .max_step_s = 1.0 / rate_hz});
  if (run.status != sim::SimulationStatus::finished)
    throw dsp::Fault(dsp::FaultKind::numerics, "export.free_run", "the equations run away: " + run.reason);
  result.x = run.states(Eigen::all, Eigen::seqN(0, layout.num_bodies, 2));
  return result;
}

}  // namespace

ExportedEquation read_exported_bodies(const fs::path& run) {
  const FinishedBodies found = read_bodies(run);
  if (found.model.layout.imposed)
    throw dsp::Fault(dsp::FaultKind::usage, "export.imposed",
                     fmt::format("{0}: its equation is of the force on an imposed motion; export writes equations of "
                                 "motion. Try ardent predict {0} on another motion, or read the force in "
                                 "{0}/equation.tex",
                                 run.string()));
  ExportedEquation result{.verdict = found.verdict,
                          .models = models_of(found.model, found.length),
                          .covariance = found.model.covariance,
                          .length = found.length};
  describe_bodies(found, result);
  const FinishedBodies::FreeRun* longest = nullptr;
  for (const FinishedBodies::FreeRun& one : found.free_runs)
    if (!std::all_of(one.state.begin(), one.state.end(), [](double value) { return std::isfinite(value); }))
      continue;  // it ran away before
    else if (longest == nullptr || one.to_s - one.from_s > longest->to_s - longest->from_s)
      longest = &one;
  const std::size_t recording = longest == nullptr ? 0 : longest->recording;
  take_coordinates(found, recording, result);
  const fs::path table = run / "prepared.csv";
  if (longest == nullptr || !fs::exists(table)) {
    result.no_run = longest == nullptr ? "the run made no free run of these equations"
                                       : "the run folder has no prepared.csv (rows = false)";
    return result;
  }
  BodiesCourse course{.motion = read_prepared_rows(table, recording + 1, result.displacements.front()).motion,
                      .samples = {},
                      .state = longest->state};
  course.samples = samples_between(course.motion, longest->from_s, longest->to_s);
  for (const std::string& input : result.inputs) {
    if (course.motion.find(input) != nullptr) continue;
    constexpr double to_rate = 0.4;  // as high as what is between samples is known
    const double rate_hz = course.motion.sample_rate_hz;
    if (input != "ddr" || course.motion.find("dr") == nullptr)
      throw dsp::Fault(dsp::FaultKind::input, "run.damaged",
                       fmt::format("{}: no column {}, which the equations look at", table.string(), printable(input)));
    course.motion.signals.push_back({input, "", ident::derived(course.motion.at("dr"), rate_hz, 1, to_rate * rate_hz)});
  }
  if (found.recordings.size() > 1) result.recording = found.recordings[recording];
  result.run = run_bodies_again(found, course, result);
  return result;
}

}  // namespace apps
