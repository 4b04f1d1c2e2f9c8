#include "apps/cli/simulate_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/cli/command.hpp"
#include "apps/config/parameter_settings.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/process/output_folder.hpp"
#include "apps/process/system_fault.hpp"
#include "apps/record_qzs.hpp"
#include "dsp/fault.hpp"
#include "dsp/names.hpp"
#include "sim/noise.hpp"
#include "sim/simulate.hpp"
#include "sim/systems.hpp"

namespace apps {
namespace {

using nlohmann::ordered_json;

constexpr double sample_rate_hz = 100.0, default_duration_s = 25.0;  // as in Section 4 of [QZS23]
constexpr std::uint64_t first_noise_id = 1000;

struct Table {
  std::vector<std::string> names;
  Eigen::MatrixXd values;
};

/// t, the states, the derivatives that are not themselves states, f. Noise on all but t and f.
Table response(const sim::Experiment& experiment, const sim::Simulation& run, double noise, std::uint64_t seed) {
  const auto num_states = run.states.cols();
  Table table{{"t"}, Eigen::MatrixXd(run.states.rows(), 2 * num_states + 1)};
  table.names.insert(table.names.end(), experiment.system.states.begin(), experiment.system.states.end());
  table.names.push_back("a");
  if (num_states == 3) table.names.push_back("dz");
  table.names.push_back("f");
  table.values << run.time_s, run.states, run.derivatives.rightCols(num_states - 1),
      run.time_s.unaryExpr(experiment.system.forcing);
  for (Eigen::Index column = 1; noise > 0.0 && column < 2 * num_states; ++column) {
    auto signal = table.values.col(column);
    const double signal_std = std::sqrt((signal.array() - signal.mean()).square().mean());
    const sim::Noise source(seed, first_noise_id + static_cast<std::uint64_t>(column));
    for (Eigen::Index n = 0; n < signal.size(); ++n)
      signal[n] += noise * signal_std * source.normal(static_cast<std::uint64_t>(n));
  }
  return table;
}

std::string csv_of(const Table& table) {
  std::string text = fmt::format("{}\n", fmt::join(table.names, ","));
  for (Eigen::Index n = 0; n < table.values.rows(); ++n)
    for (Eigen::Index c = 0; c < table.values.cols(); ++c)
      text += fmt::format("{:.17g}{}", table.values(n, c), c + 1 < table.values.cols() ? ',' : '\n');
  return text;
}

/// The systems of Section 4: response.csv, and their truth.
std::vector<std::string> simulate_system(const SimulateArguments& arguments, const OutputFolder& folder,
                                         ordered_json& truth) {
  if (arguments.raw || arguments.twin || arguments.sensors || arguments.container || arguments.frc ||
      arguments.programme || arguments.from_s || arguments.rate_hz)
    throw dsp::Fault(dsp::FaultKind::usage, "sim.option",
                     fmt::format("sim {}: --raw, --twin, --sensors, --container, --from, --rate, --frc and --programme "
                                 "belong to qzs",
                                 arguments.system));
  const auto names = sim::experiment_names();
  if (std::find(names.begin(), names.end(), arguments.system) == names.end())
    throw dsp::Fault(dsp::FaultKind::usage, "sim.option",
                     fmt::format("sim: no system '{}'; there are {}, qzs", dsp::clean_name(arguments.system),
                                 fmt::join(names, ", ")));
  sim::Experiment experiment;
  try {
    experiment = sim::make_experiment(arguments.system, parse_settings(arguments.set));
  } catch (const std::invalid_argument& error) {
    throw dsp::Fault(dsp::FaultKind::usage, "sim.option", fmt::format("sim {}", error.what()));
  }
  const double noise = arguments.noise.value_or(0.0), duration_s = arguments.duration_s.value_or(default_duration_s);
  // States, derivatives and the table's copy of both as numbers, the file's text of some 25 characters each.
  constexpr double bytes_per_value = 16.0 + 25.0;
  const double num_values = 2.0 * static_cast<double>(experiment.initial.size()) + 2.0;
  require_memory(duration_s * sample_rate_hz * num_values * bytes_per_value, fmt::format("sim {}", arguments.system),
                 "Shorten --duration");
  const auto run =
      sim::simulate(experiment.system, experiment.initial,
                    {.duration_s = duration_s, .sample_rate_hz = sample_rate_hz, .poll = check_interrupted});
  if (run.status != sim::SimulationStatus::finished)
    throw dsp::Fault(dsp::FaultKind::numerics, "sim.diverged",
                     fmt::format("sim {}. Try other parameters or a shorter --duration", run.reason));
  folder.write("response.csv", csv_of(response(experiment, run, noise, arguments.seed)));
  truth["noise"] = noise;
  truth["duration_s"] = duration_s;
  truth["omega_n"] = experiment.omega_n;
  for (const auto& [name, value] : experiment.parameters) truth["parameters"][name] = value;
  append_terms(truth["terms"], experiment.truth);
  truth["num_events"] = run.events.size();
  return {"response.csv"};
}

void check_numbers(const SimulateArguments& arguments) {
  const double noise = arguments.noise.value_or(0.0), duration_s = arguments.duration_s.value_or(1.0);
  if (!(noise >= 0.0) || !std::isfinite(noise))
    throw dsp::Fault(dsp::FaultKind::usage, "sim.noise",
                     fmt::format("sim: --noise must not be negative, got {}", noise));
  if (!(duration_s * sample_rate_hz >= 1.0) || !std::isfinite(duration_s))
    throw dsp::Fault(dsp::FaultKind::usage, "sim.duration",
                     fmt::format("sim: --duration must be at least {} s, got {}", 1.0 / sample_rate_hz, duration_s));
}

}  // namespace

void run_simulate(const SimulateArguments& arguments, Console& console) {
  check_numbers(arguments);
  ordered_json truth{{"system", arguments.system},
                     {"seed", arguments.seed},
                     {"noise", 0.0},
                     {"parameters", ordered_json::object()},
                     {"terms", ordered_json::array()},
                     {"regimes", ordered_json::array()},
                     {"num_events", 0},
                     {"sensors", ordered_json::object()}};
  OutputFolder folder(arguments.folder, arguments.force);
  Manifest manifest = begin_manifest("sim", arguments.command_line, arguments.seed, folder.destination());
  auto files = arguments.system != "qzs" ? simulate_system(arguments, folder, truth)
               : arguments.frc           ? sweep_qzs(arguments, folder, console, truth)
                                         : record_qzs(arguments, folder, console, truth);
  files.emplace_back("truth.json");
  folder.write(files.back(), truth.dump(2) + "\n");
  folder.commit(std::move(manifest));
  if (console.json()) {
    ordered_json summary{{"system", arguments.system}, {"seed", arguments.seed}, {"files", ordered_json::array()}};
    for (const auto& file : files) summary["files"].push_back(folder.shown(file).string());
    console.result(summary.dump(2) + "\n");
    return;
  }
  std::string text;
  if (truth.contains("duration_s"))
    text = fmt::format("{}: {} s, {} events\n", arguments.system, truth["duration_s"].get<double>(),
                       truth["num_events"].get<std::size_t>());
  for (const auto& file : files) text += fmt::format("  {}\n", folder.shown(file).string());
  console.result(text);
}

Command simulate_command() {
  return {
      "sim", "A known system's response and truth, as files", {{"--dry-run"}}, [](CLI::App& command) -> CommandBody {
        auto typed = std::make_shared<SimulateArguments>();
        command.add_option("SYSTEM", typed->system, "duffing, coulomb, bouc-wen, valanis-1 ... valanis-4, linear, qzs")
            ->required();
        command.add_option("--noise", typed->noise,
                           "Fraction of each signal's standard deviation; qzs: times the sensors' own");
        command.add_option("--duration", typed->duration_s, "Seconds");
        command.add_flag("--frc", typed->frc,
                         "qzs: amplitude against frequency, swept up and down; --set from_hz, to_hz, step_hz, "
                         "dwell_s, transition_s, amplitude_mm");
        command.add_option("--programme", typed->programme,
                           "qzs: down (stepped sine, the default), up, or decay (released by hand); --set "
                           "amplitude_mm, dwell_s, from_hz, to_hz, step_hz; decay: amplitude_mm, dwell_s, "
                           "releases");
        command.add_flag("--raw", typed->raw, "qzs: also the recording at 25.6 kHz");
        command.add_option("--twin", typed->twin, "qzs: T0 or T1");
        command.add_option("--sensors", typed->sensors, "qzs --raw: ideal, noise or full");
        command.add_option("--from", typed->from_s, "qzs --raw: first second of the recording");
        command.add_option("--rate", typed->rate_hz, "qzs --raw: rate of the recording, Hz; 25600 unless lower");
        command.add_option("--container", typed->container,
                           "qzs --raw: rf64 (as recording.wav, which holds more than 4 GiB), wav, w64, caf, flac, "
                           "aiff");
        command.footer(
            "Parameters of the system by --set name=number. qzs --raw, failing sensors (channel by name or index, "
            "seconds):\n"
            "  --set rail=payload_laser:300:300.4       at the upper rail\n"
            "  --set hold=2:300:300.4                   stuck at its value\n"
            "  --set clip=payload_accelerometer:0:9:0.02  limited to +-0.02 V");
        return [=](const GlobalOptions& global, Console& console) {
          SimulateArguments arguments = *typed;
          arguments.folder = required_output(global, "sim");
          arguments.force = global.force;
          arguments.seed = global.seed;
          arguments.set = global.set;
          arguments.command_line = global.command_line;
          run_simulate(arguments, console);
          return 0;
        };
      }};
}

}  // namespace apps
