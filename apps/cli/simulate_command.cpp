#include "apps/cli/simulate_command.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/cli/simulate_jobs.hpp"
#include "apps/process/output_folder.hpp"
#include "dsp/fault.hpp"

namespace apps {
namespace {

using nlohmann::ordered_json;

void check_numbers(const SimulateArguments& arguments) {
  const double noise = arguments.noise.value_or(0.0), duration_s = arguments.duration_s.value_or(1.0);
  if (!(noise >= 0.0) || !std::isfinite(noise))
    throw dsp::Fault(dsp::FaultKind::usage, "sim.noise",
                     fmt::format("sim: --noise must not be negative, got {}", noise));
  if (!(duration_s * system_rate_hz >= 1.0) || !std::isfinite(duration_s))
    throw dsp::Fault(dsp::FaultKind::usage, "sim.duration",
                     fmt::format("sim: --duration must be at least {} s, got {}", 1.0 / system_rate_hz, duration_s));
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
               : arguments.frc           ? sweep_rig(arguments, folder, console, truth)
                                         : simulate_rig(arguments, folder, console, truth);
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

}  // namespace apps
