#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/cli/simulate_jobs.hpp"
#include "apps/config/parameter_settings.hpp"
#include "apps/config/sensor_problem_settings.hpp"
#include "apps/output/rig_motion.hpp"
#include "apps/output/truth_json.hpp"
#include "apps/process/system_fault.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/values/memory_limit.hpp"
#include "sim/rig/rig_recording.hpp"
#include "sim/rig/rig_truth.hpp"

namespace apps {
namespace {

dsp::Fault no_recording(std::string_view what) {
  return {dsp::FaultKind::usage, "sim.option", fmt::format("sim qzs: {}: add --raw", what)};
}

struct Wanted {
  sim::RigTest test;
  dsp::SoundContainer container;
};

Wanted wanted_of(const SimulateArguments& arguments) try {
  if (!arguments.raw && (arguments.sensors || arguments.container || arguments.from_s || arguments.rate_hz))
    throw no_recording("--sensors, --container, --from and --rate apply to the recording");
  if (!arguments.raw && arguments.noise.value_or(0.0) != 0.0)
    throw no_recording("--noise multiplies the noise of the sensors, and response.csv is free of sensors");
  sim::RigTestOptions options;
  options.twin = arguments.twin.value_or(options.twin);
  options.programme = arguments.programme.value_or(options.programme);
  std::vector<std::string> settings = arguments.set;
  options.raw.problems = take_sensor_problems(settings);
  if (!arguments.raw && !options.raw.problems.empty()) throw no_recording("rail, hold and clip apply to the recording");
  options.settings = parse_settings(settings);
  options.from_s = arguments.from_s.value_or(options.from_s);
  options.duration_s = arguments.duration_s;
  options.rate_hz = arguments.rate_hz.value_or(options.rate_hz);
  options.raw.level = sim::sensor_level(arguments.sensors.value_or("full"));
  options.raw.noise = arguments.noise.value_or(options.raw.noise);
  options.raw.seed = arguments.seed;
  return {sim::rig_test(options), dsp::sound_container(arguments.container.value_or("rf64"))};
} catch (const std::invalid_argument& error) {
  throw refused_by_rig(error);
}

/// Throws dsp::Fault output.space where the files would not fit.
void require_space(const sim::RigTest& test, bool raw, const OutputFolder& folder) {
  constexpr double bytes_per_sample = 3.0;
  double bytes = test.duration_s * motion_bytes_per_s(raw);
  if (raw) bytes += test.duration_s * test.rate_hz * sim::num_raw_channels * bytes_per_sample;
  std::error_code unknown;
  const auto available =
      static_cast<double>(std::filesystem::space(folder.path("response.csv").parent_path(), unknown).available);
  if (!unknown && bytes > available)
    throw output_fault(
        "output.space", folder.destination(),
        fmt::format("{:.3g} MB are needed, {:.3g} MB free. Shorten --duration or write elsewhere with -o", 1e-6 * bytes,
                    1e-6 * available));
}

/// The recording and its sidecar. Returns their names.
std::vector<std::string> write_recording(const Wanted& wanted, const OutputFolder& folder, Console& console) try {
  const std::string recording = fmt::format("recording.{}", dsp::extension(wanted.container));
  const std::string sidecar = dsp::sidecar_path(recording).string();
  sim::write_rig_recording(wanted.test, folder.path(recording),
                           {wanted.container, folder.shown(recording), shown_progress(console, "recording")});
  folder.write(sidecar, sim::rig_sidecar(wanted.test));
  return {recording, sidecar};
} catch (const std::invalid_argument& error) {
  throw refused_by_rig(error);
}

}  // namespace

dsp::Fault refused_by_rig(const std::invalid_argument& error) {
  const std::string_view why = error.what();
  return {dsp::FaultKind::usage, "sim.option", fmt::format("sim {}{}", why.starts_with("qzs: ") ? "" : "qzs: ", why)};
}

std::vector<std::string> simulate_rig(const SimulateArguments& arguments, const OutputFolder& folder, Console& console,
                                      nlohmann::ordered_json& truth) try {
  const Wanted wanted = wanted_of(arguments);
  const sim::RigTest& test = wanted.test;
  require_space(test, arguments.raw, folder);
  dsp::require_machine_memory("sim qzs", sim::rig_truth_bytes(test), "Shorten --duration or lower --from");
  std::vector<std::string> files{"response.csv"};
  if (arguments.raw) {  // first: what the container cannot hold is refused at once
    files.emplace_back("truth.csv");
    for (std::string& name : write_recording(wanted, folder, console)) files.push_back(std::move(name));
  }
  put_rig_truth(truth, test, write_motion(test, arguments.raw, folder, shown_progress(console, "motion")),
                arguments.raw);
  return files;
} catch (const sim::Diverged& error) {
  throw dsp::Fault(dsp::FaultKind::numerics, "sim.diverged",
                   fmt::format("sim {}. Try other parameters or a shorter --duration", error.what()));
}

}  // namespace apps
