#include "apps/cli/simulate_command.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/cli/command.hpp"
#include "apps/cli/simulate_jobs.hpp"
#include "apps/config/parameter_settings.hpp"
#include "apps/output/output_folder.hpp"
#include "apps/text/json_parts.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace apps {
namespace {

using nlohmann::ordered_json;

void check_numbers(const SimulateArguments& arguments) {
  constexpr double most_s = 1e9;  // where times of a table are still a microsecond apart or better
  require_within(arguments.noise.value_or(0.0), 0.0, most_noise, "sim.noise", "sim: --noise");
  require_within(arguments.duration_s.value_or(1.0), 1.0 / system_rate_hz, most_s, "sim.duration", "sim: --duration");
  require_within(arguments.from_s.value_or(0.0), 0.0, most_s, "sim.option", "sim: --from");
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
  if (arguments.lag_s && (arguments.drive.empty() || arguments.system == "chain"))
    throw dsp::Fault(dsp::FaultKind::usage, "sim.option",
                     fmt::format("sim {}: --lag is of a force that --drive names, and not of chain",
                                 dsp::clean_name(arguments.system)));
  if (!arguments.drive.empty() && arguments.system == "qzs")
    throw dsp::Fault(
        dsp::FaultKind::usage, "sim.option",
        fmt::format("sim {}: --drive is not of qzs, which its programme drives", dsp::clean_name(arguments.system)));
  auto files = arguments.system == "chain" ? simulate_chain(arguments, folder, console, truth)
               : arguments.system != "qzs" ? simulate_system(arguments, folder, console, truth)
               : arguments.frc             ? sweep_rig(arguments, folder, console, truth)
                                           : simulate_rig(arguments, folder, console, truth);
  files.emplace_back("truth.json");
  folder.write(files.back(), text_of(truth));
  folder.commit(std::move(manifest));
  if (console.json()) {
    ordered_json summary{{"system", arguments.system}, {"seed", arguments.seed}, {"files", ordered_json::array()}};
    for (const auto& file : files) summary["files"].push_back(folder.shown(file).string());
    console.result(text_of(summary));
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
  const auto typed = std::make_shared<SimulateArguments>();
  return {
      .name = "sim",
      .help = "A known system's response and truth, as files",
      .group = made_group,
      .unused = {{"--dry-run"}, {"--threads"}},
      .options =
          {{"SYSTEM",
            &typed->system,
            "duffing, coulomb, bouc-wen, valanis-1 ... valanis-4, linear, chain (several masses), qzs.",
            {.required = true}},
           {"--noise", &typed->noise,
            "Noise as a fraction of each signal's standard deviation; qzs: times the nominal noise of the sensors."},
           {"--duration", &typed->duration_s, "Length in seconds."},
           {"--drive",
            &typed->drive,
            "A recording whose force f drives the system in place of a sine, force_n being 1 then; chain with --set "
            "base=1: whose r.",
            {.name = "FILE"}},
           {"--lag", &typed->lag_s,
            "With --drive, not of chain: seconds by which an actuator of first order passes the force on late. f in "
            "the table is the force before it."},
           {"--frc", &typed->frc,
            "qzs: amplitude against frequency, swept up and down; --set from_hz, to_hz, step_hz, dwell_s, "
            "transition_s, amplitude_mm."},
           {"--programme", &typed->programme,
            "qzs: down (stepped sine, the default), up, or decay (released by hand); --set amplitude_mm, dwell_s, "
            "from_hz, to_hz, step_hz; decay: amplitude_mm, dwell_s, releases."},
           {"--raw", &typed->raw, "qzs: also the recording at 25.6 kHz."},
           {"--twin", &typed->twin, "qzs: T0 or T1."},
           {"--sensors", &typed->sensors, "qzs --raw: ideal, noise, full or random."},
           {"--from", &typed->from_s, "qzs --raw: first second of the recording."},
           {"--rate", &typed->rate_hz, "qzs --raw: rate of the recording, Hz; 25600 unless lower."},
           {"--container", &typed->container,
            "qzs --raw: rf64 (as recording.wav, which holds more than 4 GiB), wav, w64, caf, flac, aiff."}},
      .run =
          [typed](const GlobalOptions& global, Console& console) {
            SimulateArguments arguments = *typed;
            arguments.folder = required_output(global, "sim");
            arguments.force = global.force;
            arguments.seed = global.seed;
            arguments.set = global.set;
            arguments.command_line = global.command_line;
            run_simulate(arguments, console);
            return 0;
          },
      .more = {"Parameters of the system: --set name=number. Of chain: masses, base (1: base driven),",
               "driven (body), mass, stiffness, damping, cubic, friction (mass_2 ...: of one body and",
               "the link below it), and of the random drive from_hz, to_hz, rms. Failing sensors of",
               "qzs --raw, by channel (name or index) and seconds:",
               "  --set rail=payload_laser:300:300.4         at the upper rail",
               "  --set hold=2:300:300.4                     stuck at its value",
               "  --set clip=payload_accelerometer:0:9:0.02  limited to +-0.02 V"},
      .examples = {"ardent sim duffing -o duffing --noise 0.05", "ardent sim qzs --raw -o rig",
                   "ardent sim chain -o chain --noise 0.01 --set masses=3 --set base=1 --set cubic_2=2e4"}};
}

}  // namespace apps
