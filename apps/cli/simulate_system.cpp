#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "apps/cli/simulate_jobs.hpp"
#include "apps/config/parameter_settings.hpp"
#include "apps/output/truth_json.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/values/memory_limit.hpp"
#include "dsp/values/names.hpp"
#include "sim/noise.hpp"
#include "sim/simulate.hpp"
#include "sim/systems.hpp"

namespace apps {
namespace {

using nlohmann::ordered_json;

constexpr double default_duration_s = 25.0;  // as in Section 4 of [QZS23]
constexpr std::uint64_t first_noise_id = 1000;

struct Table {
  std::vector<std::string> names;
  Eigen::MatrixXd values;
};

/// t, the states, the derivatives that are not themselves states, f. Noise on all but t and f.
Table response(const sim::Experiment& experiment, const sim::Simulation& run, const sim::Forcing& force, double noise,
               std::uint64_t seed) {
  const auto num_states = run.states.cols();
  Table table{{"t"}, Eigen::MatrixXd(run.states.rows(), 2 * num_states + 1)};
  table.names.insert(table.names.end(), experiment.system.states.begin(), experiment.system.states.end());
  table.names.push_back("a");
  if (num_states == 3) table.names.push_back("dz");
  table.names.push_back("f");
  table.values << run.time_s, run.states, run.derivatives.rightCols(num_states - 1), run.time_s.unaryExpr(force);
  for (Eigen::Index column = 1; noise > 0.0 && column < 2 * num_states; ++column)
    add_noise(table.values.col(column), noise, seed, first_noise_id + static_cast<std::uint64_t>(column));
  return table;
}

}  // namespace

void refuse_options_of_rig(const SimulateArguments& arguments) {
  if (arguments.raw || arguments.twin || arguments.sensors || arguments.container || arguments.frc ||
      arguments.programme || arguments.from_s || arguments.rate_hz)
    throw dsp::Fault(dsp::FaultKind::usage, "sim.option",
                     fmt::format("sim {}: --raw, --twin, --sensors, --container, --from, --rate, --frc and --programme "
                                 "belong to qzs",
                                 arguments.system));
}

sim::Drive recorded_drive(const std::filesystem::path& file, bool is_base, double& duration_s) {
  const dsp::Recording recording = dsp::read_recording(file, {.uncalibrated = true});
  Eigen::Index column = recording.find(is_base ? dsp::Role::r : dsp::Role::f);
  if (column < 0 && recording.channels.size() == 1) column = 0;
  if (column < 0)
    throw dsp::Fault(dsp::FaultKind::input, "sim.drive",
                     fmt::format("{}: no channel is the {}. Want a column called {}", recording.name,
                                 is_base ? "displacement of the base" : "force", is_base ? "r" : "f"));
  if (duration_s == 0.0) duration_s = static_cast<double>(recording.samples.rows() - 1) / recording.sample_rate_hz;
  const Eigen::VectorXd samples = recording.samples.col(column);
  return sim::recorded_drive({samples.begin(), samples.end()}, recording.sample_rate_hz);
}

void add_noise(Eigen::Ref<Eigen::VectorXd> signal, double fraction, std::uint64_t seed, std::uint64_t number) {
  const double signal_std = std::sqrt((signal.array() - signal.mean()).square().mean());
  const sim::Noise source(seed, number);
  for (Eigen::Index n = 0; n < signal.size(); ++n)
    signal[n] += fraction * signal_std * source.normal(static_cast<std::uint64_t>(n));
}

std::string csv_of(const std::vector<std::string>& names, const Eigen::MatrixXd& values) {
  std::string text = fmt::format("{}\n", fmt::join(names, ","));
  for (Eigen::Index n = 0; n < values.rows(); ++n)
    for (Eigen::Index c = 0; c < values.cols(); ++c)
      text += fmt::format("{:.17g}{}", values(n, c), c + 1 < values.cols() ? ',' : '\n');
  return text;
}

std::vector<std::string> simulate_system(const SimulateArguments& arguments, const OutputFolder& folder,
                                         Console& console, ordered_json& truth) {
  refuse_options_of_rig(arguments);
  const auto names = sim::experiment_names();
  if (std::find(names.begin(), names.end(), arguments.system) == names.end()) {
    const std::string near = dsp::nearest(arguments.system, {names.begin(), names.end()});
    throw dsp::Fault(dsp::FaultKind::usage, "sim.option",
                     fmt::format("sim: no system '{}'; there are {}, chain, qzs{}", dsp::clean_name(arguments.system),
                                 fmt::join(names, ", "), near.empty() ? "" : fmt::format(". Did you mean {}?", near)));
  }
  sim::Experiment experiment;
  double duration_s = arguments.duration_s.value_or(0.0);
  sim::Forcing commanded;
  try {
    auto set = parse_settings(arguments.set);
    sim::Forcing drive;
    if (!arguments.drive.empty()) {
      const sim::Drive recorded = recorded_drive(arguments.drive, false, duration_s);
      commanded = recorded.value;
      drive = arguments.lag_s ? sim::lagged(recorded, *arguments.lag_s, duration_s).value : recorded.value;
      if (std::any_of(set.begin(), set.end(), [](const auto& one) { return one.first == "ratio"; }))
        throw std::invalid_argument(arguments.system +
                                    ": ratio is of the sine that --drive replaces. Leave one of them out");
      set.insert(set.begin(), {"force_n", 1.0});  // unless it is set
    }
    experiment = sim::make_experiment(arguments.system, set, drive);
  } catch (const std::invalid_argument& error) {
    throw dsp::Fault(dsp::FaultKind::usage, "sim.option", fmt::format("sim {}", error.what()));
  }
  if (duration_s == 0.0) duration_s = default_duration_s;
  const double noise = arguments.noise.value_or(0.0);
  // States, derivatives and the table's copy of both as numbers, the file's text of some 25 characters each.
  constexpr double bytes_per_value = 16.0 + 25.0;
  const double num_values = 2.0 * static_cast<double>(experiment.initial.size()) + 2.0;
  dsp::require_machine_memory(fmt::format("sim {}", arguments.system),
                              duration_s * system_rate_hz * num_values * bytes_per_value, "Shorten --duration");
  const sim::SimulateOptions options{
      .duration_s = duration_s, .sample_rate_hz = system_rate_hz, .poll = shown_poll(console, "simulating")};
  const auto run = sim::simulate(experiment.system, experiment.initial, options);
  if (run.status == sim::SimulationStatus::step_limit)
    throw dsp::Fault(
        dsp::FaultKind::numerics, "sim.too_fast",
        fmt::format("sim {}: its natural frequency is {:.3g} Hz, and a table at {:g} Hz shows what is "
                    "below {:g} Hz. Try --set of slower parameters",
                    run.reason, experiment.omega_n / (2.0 * std::numbers::pi), system_rate_hz, 0.5 * system_rate_hz));
  if (run.status != sim::SimulationStatus::finished)
    throw dsp::Fault(dsp::FaultKind::numerics, "sim.diverged",
                     fmt::format("sim {}. Try other parameters or a shorter --duration", run.reason));
  const Table table =
      response(experiment, run, arguments.lag_s ? commanded : experiment.system.forcing, noise, arguments.seed);
  folder.write("response.csv", csv_of(table.names, table.values));
  truth["noise"] = noise;
  truth["duration_s"] = duration_s;
  truth["omega_n"] = experiment.omega_n;
  if (arguments.lag_s) truth["lag_s"] = *arguments.lag_s;
  put_equation(truth, experiment.parameters, experiment.truth);
  truth["num_events"] = run.events.size();
  const auto error = sim::simulation_error(experiment.system, experiment.initial, options, run);
  if (std::isfinite(error.growth)) {
    for (std::size_t i = 0; i < experiment.system.states.size(); ++i)
      truth["relative_error"][experiment.system.states[i]] = error.relative[static_cast<Eigen::Index>(i)];
    truth["error_growth"] = error.growth;
  } else {
    truth["relative_error_reason"] = "at a tolerance ten times as large another number of switches is passed";
  }
  return {"response.csv"};
}

}  // namespace apps
