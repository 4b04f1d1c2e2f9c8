#include "apps/cli/run_arguments.hpp"

#include <fmt/format.h>

#include "apps/config/identification.hpp"
#include "apps/process/sha256.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/values/faults.hpp"
#include "dsp/values/names.hpp"

namespace apps {
namespace fs = std::filesystem;

std::vector<Option> run_options(RunArguments& typed, const char* input, const char* help) {
  constexpr std::size_t bytes_per_mb = 1'000'000;
  const auto take_memory = [&typed](const std::string& mb) { typed.max_memory_bytes = std::stoull(mb) * bytes_per_mb; };
  return {{input, &typed.input, help, {.required = true, .is_recording = true}},
          {"--salvage", &typed.salvage, "Read a recording that was cut short, as far as it goes."},
          {"--uncalibrated", &typed.uncalibrated, "Take channels without a sensitivity as raw numbers."},
          {"--sidecar",
           &typed.sidecar,
           "Sidecar of the recording; several recordings may share one. Left out: NAME.ext.toml beside it.",
           {.name = "FILE"}},
          {"--max-memory",
           take_memory,
           "Most memory that a recording may take.",
           {.name = "MB", .check = whole_number(1, 1 << 30)}}};
}

std::vector<Option> less_options(RunArguments& typed) {
  return {{"--no-rows", &typed.no_rows,
           "Leave out the tables with a row for each sample: prepared.csv, predictions.csv, predict-N-NAME.csv."},
          {"--no-figures", &typed.no_figures, "Leave out figures/; report.html has its figures all the same."}};
}

RunArguments with_global(RunArguments typed, const GlobalOptions& global) {
  typed.folder = global.output;
  typed.force = global.force;
  typed.dry_run = global.dry_run;
  typed.strict = global.strict;
  typed.num_threads = thread_count(global);
  typed.seed = global.seed;
  typed.set = global.set;
  typed.command_line = global.command_line;
  return typed;
}

namespace {

/// What the command line says of every recording.
void apply_flags(const RunArguments& arguments, Config& config) {
  for (RecordingConfig& recording : config.recordings) {
    recording.salvage = recording.salvage || arguments.salvage;
    recording.uncalibrated = recording.uncalibrated || arguments.uncalibrated;
  }
  config.rows = config.rows && !arguments.no_rows;
  config.figures = config.figures && !arguments.no_figures;
  if (arguments.sidecar.empty()) return;
  for (auto* recordings : {&config.recordings, &config.test_recordings})
    for (RecordingConfig& recording : *recordings) recording.sidecar = arguments.sidecar;
}

}  // namespace

Config config_of(const RunArguments& arguments) {
  if (!arguments.recording.empty() && arguments.input.extension() != ".toml")
    throw dsp::Fault(
        dsp::FaultKind::usage, "usage",
        fmt::format("{}: want a config NAME.toml before the recording {}. Of a recording alone: ardent run {}",
                    arguments.input.string(), arguments.recording.string(), arguments.recording.string()));
  Config config = read_config(arguments.input, arguments.set, arguments.recording);
  apply_flags(arguments, config);
  return config;
}

fs::path folder_apart(const RunArguments& arguments, const Config& config, const char* suffix) {
  const fs::path& named = arguments.recording.empty() ? arguments.input : arguments.recording;
  const fs::path folder =
      arguments.folder.empty() ? fs::path(dsp::slug(named.stem().string()) + suffix) : arguments.folder;
  std::vector<fs::path> inputs = input_files(config);
  inputs.push_back(arguments.input);
  require_apart(folder, inputs);
  return folder;
}

RunFolder::Origin origin_of(const RunArguments& arguments, std::string command, const Config& config) {
  RunFolder::Origin origin{std::move(command), arguments.command_line, arguments.seed, {}};
  origin.num_threads = arguments.num_threads;
  origin.request = sha256(fmt::format("{}\n{}\nstrict {} require {}", origin.command,
                                      to_toml(config, arguments.folder.empty() ? "." : arguments.folder),
                                      arguments.strict, arguments.require));
  if (arguments.input.extension() == ".toml") origin.files.push_back(arguments.input);
  if (!config.segment_file.empty()) origin.files.push_back(config.segment_file);
  return origin;
}

std::string plan_text(const RunArguments& arguments, const Config& config) {
  std::string text;
  for (const RecordingConfig& recording : config.recordings) {
    const dsp::RecordingReader reader(recording.file, read_options(recording, arguments.max_memory_bytes));
    const dsp::Recording& description = reader.description();
    const double rate_hz = config.prepare.rate_hz > 0.0 ? config.prepare.rate_hz : description.sample_rate_hz;
    const double duration_s = static_cast<double>(reader.num_frames()) / description.sample_rate_hz;
    text += fmt::format("{}: {} samples of {} channels at {:.9g} Hz, {:.6g} s; {:.0f} rows at {:.9g} Hz\n",
                        recording.name, reader.num_frames(), description.channels.size(), description.sample_rate_hz,
                        duration_s, duration_s * rate_hz, rate_hz);
  }
  return text + fmt::format("would write {}\n", folder_apart(arguments, config, "-run").string());
}

Work prepare_work(Config config, const RunArguments& arguments, Console& console) {
  dsp::Faults faults;
  if (!faults.attempt([&] { check_library(config); })) {
    faults.attempt([&] { look_at_recordings(config, arguments.max_memory_bytes); });
    faults.raise();
  }
  Work work{std::move(config), {}};
  work.inputs = prepare_inputs(work.config, arguments.max_memory_bytes, arguments.num_threads, console);
  settle(work.config, work.inputs, console);
  name_channels(work.config, work.inputs);
  refuse_warnings(arguments.strict, console);
  return work;
}

}  // namespace apps
