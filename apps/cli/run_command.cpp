#include "apps/cli/run_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "apps/config/config.hpp"
#include "apps/config/identification.hpp"
#include "apps/config/inputs.hpp"
#include "apps/output/fit_outcome.hpp"
#include "apps/output/report_text.hpp"
#include "apps/output/results_json.hpp"
#include "apps/output/segments_file.hpp"
#include "apps/output/steps_table.hpp"
#include "apps/output/tables.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/process/output_folder.hpp"
#include "apps/process/printable.hpp"
#include "dsp/names.hpp"
#include "ident/identify.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

Config config_of(const RunArguments& arguments) {
  Config config = read_config(arguments.input, arguments.set);
  for (RecordingConfig& recording : config.recordings) {
    recording.salvage = recording.salvage || arguments.salvage;
    recording.uncalibrated = recording.uncalibrated || arguments.uncalibrated;
  }
  return config;
}

/// Everything between the config and the columns.
struct Work {
  Config config;
  std::vector<Input> inputs;
};

Work prepare_work(Config config, const RunArguments& arguments, Console& console) {
  check_library(config);
  Work work{std::move(config), {}};
  work.inputs = prepare_inputs(work.config, arguments.max_memory_bytes, console);
  settle(work.config, work.inputs, console);
  refuse_warnings(arguments.strict, console);
  return work;
}

fs::path output_folder(const RunArguments& arguments) {
  return arguments.folder.empty() ? fs::path(dsp::slug(arguments.input.stem().string()) + "-run") : arguments.folder;
}

/// The run folder's place, once it is known to touch no input.
fs::path place_apart(const RunArguments& arguments, const Config& config) {
  std::vector<fs::path> inputs = input_files(config);
  inputs.push_back(arguments.input);
  require_apart(output_folder(arguments), inputs);
  return output_folder(arguments);
}

std::vector<const dsp::Prepared*> prepared_of(const std::vector<Input>& inputs) {
  std::vector<const dsp::Prepared*> prepared;
  for (const Input& input : inputs) prepared.push_back(&input.prepared);
  return prepared;
}

/// Of the recordings that are stepped sines.
std::vector<RecordingSteps> steady_steps(const std::vector<Input>& inputs) {
  std::vector<RecordingSteps> all;
  for (const Input& input : inputs)
    if (auto steps = dsp::find_steady_steps(input.prepared.signals); !steps.empty())
      all.emplace_back(input.prepared.name, std::move(steps));
  return all;
}

/// A run folder being filled, and the manifest that closes it.
class Results {
 public:
  Results(const RunArguments& arguments, std::string command, const Config& config)
      : folder_(place_apart(arguments, config), arguments.force),
        manifest_(begin_manifest(std::move(command), arguments.command_line, arguments.seed, folder_.destination())) {
    if (arguments.input.extension() == ".toml") add_input(manifest_, arguments.input, folder_.destination());
    if (!config.segment_file.empty()) add_input(manifest_, config.segment_file, folder_.destination());
  }
  void add_inputs(const std::vector<Input>& inputs) {
    for (const Input& input : inputs)
      for (const fs::path& file : input.files) add_input(manifest_, file, folder_.destination());
  }
  void write(const std::string& name, std::string_view bytes) {
    stream(name, [&](const Sink& sink) { sink(bytes); });
  }
  void stream(const std::string& name, const std::function<void(const Sink&)>& fill) {
    OutputFile file = folder_.file(name);
    fill([&](std::string_view bytes) { file.write(bytes); });
    file.close();
    check_interrupted();
  }
  /// What every run folder holds, and the manifest last.
  void finish(const Config& config, const std::vector<Input>& inputs, Console& console) {
    stream("prepared.csv", [&](const Sink& sink) { write_prepared(prepared_of(inputs), sink); });
    write("quality.json", quality_json(inputs));
    write("segments.json", segments_json(inputs));
    if (const auto steps = steady_steps(inputs); !steps.empty()) write("steps.csv", steps_csv(steps));
    write("config.toml", to_toml(config, folder_.destination()));
    write("log.txt", console.log());
    manifest_.warnings = console.warnings();
    manifest_.calibrated = std::all_of(inputs.begin(), inputs.end(),
                                       [](const Input& input) { return input.prepared.signals.uncalibrated.empty(); });
    folder_.commit(std::move(manifest_));
  }
  [[nodiscard]] const fs::path& destination() const { return folder_.destination(); }

 private:
  OutputFolder folder_;
  Manifest manifest_;
};

/// What a run would do, from the headers of its recordings.
void print_plan(const RunArguments& arguments, const Config& config, Console& console) {
  std::string text;
  for (const RecordingConfig& recording : config.recordings) {
    const dsp::RecordingReader reader(recording.file, read_options(recording, arguments.max_memory_bytes));
    const dsp::Recording& description = reader.description();
    const double rate_hz = config.prepare.rate_hz > 0.0 ? config.prepare.rate_hz : description.sample_rate_hz;
    const double duration_s = static_cast<double>(reader.num_frames()) / description.sample_rate_hz;
    text += fmt::format("{}: {} samples of {} channels at {:.9g} Hz, {:.6g} s; {:.0f} rows at {:.9g} Hz\n",
                        recording.file.filename().string(), reader.num_frames(), description.channels.size(),
                        description.sample_rate_hz, duration_s, duration_s * rate_hz, rate_hz);
  }
  console.result(text + fmt::format("would write {}\n", place_apart(arguments, config).string()));
}

/// 4 and a message where a range has no fit to show.
int exit_code_of(const std::vector<ident::RangeResult>& ranges, Console& console) {
  int code = 0;
  for (const ident::RangeResult& range : ranges)
    code = std::max(code, outcome_of(range.fits, fmt::format("range '{}'", range.spec.name), console));
  return code;
}

}  // namespace

int run_identification(const RunArguments& arguments, Console& console) {
  const Config config = config_of(arguments);
  if (arguments.dry_run) {
    print_plan(arguments, config, console);
    return 0;
  }
  Results results(arguments, "run", config);
  Work work = prepare_work(config, arguments, console);
  results.add_inputs(work.inputs);
  const auto libraries = compile_libraries(work.config, work.inputs);
  std::vector<ident::Columns> columns =
      all_columns(work.config, work.inputs, libraries, arguments.max_memory_bytes, console);
  const ident::IdentifyOptions options = identify_options(work.config, work.inputs, arguments.num_threads);
  auto ranges = identify_ranges(work.config, columns, libraries.front(), options, console);
  refuse_warnings(arguments.strict, console);
  const std::string report = report_text(ranges) + findings_text(work.inputs);
  results.write("equation.txt", report);
  results.write("equation.tex", report_latex(ranges));
  results.write("equation.json", equation_json(ranges));
  results.write("metrics.json", metrics_json(ranges, options));
  results.stream("predictions.csv", [&](const Sink& sink) { write_predictions(ranges, columns, sink); });
  results.finish(work.config, work.inputs, console);
  console.result(console.json() ? equation_json(ranges)
                                : fmt::format("{}\nresults are in {}\n", report, results.destination().string()));
  return exit_code_of(ranges, console);
}

void run_preparation(const RunArguments& arguments, Console& console) {
  const Config config = config_of(arguments);
  if (arguments.dry_run) return print_plan(arguments, config, console);
  Results results(arguments, "prep", config);
  const Work work = prepare_work(config, arguments, console);
  results.add_inputs(work.inputs);
  results.finish(work.config, work.inputs, console);
  console.result(console.json() ? quality_json(work.inputs)
                                : fmt::format("prepared signals are in {}\n", results.destination().string()));
}

void run_check(const RunArguments& arguments, Console& console) {
  const Work work = prepare_work(config_of(arguments), arguments, console);
  const std::vector<ident::Columns> columns = all_columns(
      work.config, work.inputs, compile_libraries(work.config, work.inputs), arguments.max_memory_bytes, console);
  std::string text;
  for (const Input& input : work.inputs)
    for (const dsp::Check& check : input.prepared.checks)
      text += fmt::format("{:<8} {}: {}: {}{}\n", to_string(check.status), input.prepared.name, check.name,
                          printable(channel_prefix(check)), printable(check.message));
  for (const ident::Range& range : work.config.ranges) {
    const ident::RangeRows rows = ident::range_rows(range, columns);
    text += fmt::format("{:<8} range {}: {} training rows, {} test rows\n", "ok", range.spec.name, rows.train.size(),
                        rows.test.size());
  }
  console.result(console.json() ? checks_json(work.inputs) : text);
}

}  // namespace apps
