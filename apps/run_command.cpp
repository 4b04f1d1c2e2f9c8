#include "apps/run_command.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <new>

#include "apps/atomic_file.hpp"
#include "apps/columns.hpp"
#include "apps/config.hpp"
#include "apps/identify.hpp"
#include "apps/inputs.hpp"
#include "apps/interrupt.hpp"
#include "apps/printable.hpp"
#include "apps/report_text.hpp"
#include "apps/results_json.hpp"
#include "apps/run_folder.hpp"
#include "apps/sha256.hpp"
#include "apps/tables.hpp"
#include "dsp/names.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

std::string utc_now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

Config config_of(const RunArguments& arguments) {
  Config config = read_config(arguments.input, arguments.set);
  for (RecordingConfig& recording : config.recordings) {
    recording.salvage = recording.salvage || arguments.salvage;
    recording.uncalibrated = recording.uncalibrated || arguments.uncalibrated;
  }
  return config;
}

/// Everything between the config and the fits.
struct Work {
  Config config;
  std::vector<Input> inputs;
  std::vector<ident::CandidateLibrary> libraries;  ///< one compiled for each recording, all of the same terms
};

/// A fault about terms, with their place in the config before it.
template <class Call>
auto at_place(const std::string& place, Call&& call) {
  try {
    return call();
  } catch (const dsp::Fault& fault) {
    throw dsp::Fault(fault.kind(), fault.name(), place + ": " + fault.what());
  }
}

void refuse_warnings(const RunArguments& arguments, const Console& console) {
  if (arguments.strict && !console.warnings().empty())
    throw dsp::Fault(dsp::FaultKind::input, "strict.warning",
                     fmt::format("stopped at the first warning (--strict): {}", console.warnings().front()));
}

/// What is wrong with the library whatever the recordings hold, found before they are read.
void check_library(const Config& config) {
  dsp::Motion usual;
  for (const char* name : {"t", "x", "v", "a", "r", "dr", "ddr", "y", "dy", "ddy", "f", "z"})
    usual.signals.push_back({name, "", {}});
  try {
    at_place(config.library_place, [&] { return ident::make_library(config.library, config.fit.target, usual); });
  } catch (const dsp::Fault& fault) {
    if (fault.name() != "term.unknown_name") throw;  // a channel may have that name
  }
}

Work prepare_work(Config config, const RunArguments& arguments, Console& console) {
  check_library(config);
  Work work{std::move(config), {}, {}};
  work.inputs = prepare_inputs(work.config, arguments.max_memory_bytes, console);
  settle(work.config, work.inputs, console);
  refuse_warnings(arguments, console);
  return work;
}

void compile_libraries(Work& work) {
  const FitConfig& fit = work.config.fit;
  for (const Input& input : work.inputs) {
    const dsp::Motion& signals = input.prepared.signals;
    if (signals.find(fit.target) == nullptr) {
      std::string known;
      for (const dsp::Signal& signal : signals.signals) known += (known.empty() ? "" : ", ") + signal.name;
      throw dsp::Fault(dsp::FaultKind::usage, "target.unknown",
                       fmt::format("{}: target: {} has no signal '{}', want one of {}.", fit.place, input.prepared.name,
                                   fit.target, known));
    }
    work.libraries.push_back(at_place(work.config.library_place,
                                      [&] { return ident::make_library(work.config.library, fit.target, signals); }));
    for (const ident::Term& term : work.libraries.back().terms)
      for (const std::string& signal : term.expression.signals())
        if (signal == fit.target)
          throw dsp::Fault(
              dsp::FaultKind::usage, "library.target",
              fmt::format("{}: the term '{}' contains the target {} and would explain it by itself. Remove it.",
                          work.config.library_place, term.name, fit.target));
  }
}

std::vector<Columns> all_columns(const Work& work, Console& console) {
  std::vector<Columns> columns;
  for (std::size_t i = 0; i < work.inputs.size(); ++i) {
    const dsp::Prepared& prepared = work.inputs[i].prepared;
    const std::size_t bytes =
        sizeof(double) * static_cast<std::size_t>(prepared.signals.num_samples()) * work.libraries[i].terms.size();
    console.step(fmt::format("{}: forming {} columns ({:.1f} MB)", prepared.name, work.libraries[i].terms.size(),
                             1e-6 * static_cast<double>(bytes)));
    try {
      columns.push_back(form_columns(work.libraries[i], work.config.fit.target, prepared));
      columns.back().regimes = work.inputs[i].regimes;
    } catch (const std::bad_alloc&) {
      throw dsp::Fault(dsp::FaultKind::numerics, "memory.exhausted",
                       fmt::format("{}: no memory for {} columns, {:.1f} MB. Use fewer terms or a lower rate.",
                                   prepared.name, work.libraries[i].terms.size(), 1e-6 * static_cast<double>(bytes)));
    }
  }
  return columns;
}

IdentifyOptions identify_options(const Config& config, const dsp::Motion& signals, int num_threads) {
  return {.target = config.fit.target,
          .target_unit = signals.find(config.fit.target)->unit,
          .methods = config.fit.methods,
          .selection = config.fit.selection,
          .tau = config.fit.tau,
          .threshold = config.fit.threshold,
          .unit_norm_threshold = config.fit.unit_norm_threshold,
          .num_threads = num_threads};
}

fs::path output_folder(const RunArguments& arguments) {
  return arguments.folder.empty() ? fs::path(dsp::slug(arguments.input.stem().string()) + "-run") : arguments.folder;
}

std::string relative_to_run(const fs::path& path, const fs::path& folder) {
  return fs::weakly_canonical(fs::absolute(path))
      .lexically_relative(fs::weakly_canonical(fs::absolute(folder)))
      .generic_string();
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

/// A run folder being filled, and the manifest that closes it.
class Results {
 public:
  Results(const RunArguments& arguments, std::string command, const Config& config)
      : folder_(place_apart(arguments, config), arguments.force) {
    manifest_.command = std::move(command);
    manifest_.started_utc = utc_now();
    manifest_.seed = arguments.seed;
    for (const std::string& argument : arguments.command_line)  // where things lie on this machine is nobody's business
      manifest_.arguments.push_back(fs::path(argument).is_absolute() ? relative_to_run(argument, folder_.destination())
                                                                     : argument);
    if (arguments.input.extension() == ".toml") add_input(arguments.input);
  }
  void add_inputs(const std::vector<Input>& inputs) {
    for (const Input& input : inputs)
      for (const fs::path& file : input.files) add_input(file);
  }
  void write(const std::string& name, std::string_view bytes) {
    stream(name, [&](const Sink& sink) { sink(bytes); });
  }
  void stream(const std::string& name, const std::function<void(const Sink&)>& fill) {
    AtomicFile file(folder_.path(name));
    fill([&](std::string_view bytes) { file.write(bytes); });
    file.commit();
    written_.push_back(name);
    check_interrupted();
  }
  /// What every run folder holds, and the manifest last.
  void finish(const Config& config, const std::vector<Input>& inputs, Console& console) {
    stream("prepared.csv", [&](const Sink& sink) { write_prepared(prepared_of(inputs), sink); });
    write("quality.json", quality_json(inputs));
    write("segments.json", segments_json(inputs));
    write("config.toml", to_toml(config, folder_.destination()));
    write("log.txt", console.log());
    for (const std::string& name : written_) manifest_.outputs.push_back({name, sha256_file(folder_.path(name))});
    manifest_.warnings = console.warnings();
    manifest_.finished_utc = utc_now();
    folder_.commit(manifest_json(manifest_));
  }
  [[nodiscard]] const fs::path& destination() const { return folder_.destination(); }

 private:
  void add_input(const fs::path& path) {
    manifest_.inputs.push_back({relative_to_run(path, folder_.destination()), sha256_file(path)});
  }
  RunFolder folder_;
  Manifest manifest_;
  std::vector<std::string> written_;
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

std::vector<RangeResult> identify_ranges(Work& work, const std::vector<Columns>& columns, const RunArguments& arguments,
                                         IdentifyOptions& options, Console& console) {
  options = identify_options(work.config, work.inputs.front().prepared.signals, arguments.num_threads);
  std::vector<RangeResult> ranges;
  for (Range& range : work.config.ranges) {
    console.step(fmt::format("range {}: fitting", range.spec.name));
    ranges.push_back(identify(range, columns, work.libraries.front(), options));
    range.spec = ranges.back().spec;
    for (const DroppedTerm& term : ranges.back().dropped)
      console.warning("term.left_out",
                      fmt::format("range {}: {} is left out: {}", range.spec.name, term.name, term.reason));
  }
  return ranges;
}

/// 4 and a message where a range has no method that selected anything.
int exit_code_of(const std::vector<RangeResult>& ranges, Console& console) {
  int code = 0;
  for (const RangeResult& range : ranges) {
    const bool any = std::any_of(range.fits.begin(), range.fits.end(),
                                 [](const JudgedFit& fit) { return !fit.model.terms.empty(); });
    if (any) continue;
    code = 4;
    console.error(
        "fit.nothing_selected",
        fmt::format("range '{}': no method selected a term. Give other candidates, or lower fit.tau or fit.threshold.",
                    range.spec.name));
  }
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
  compile_libraries(work);
  const std::vector<Columns> columns = all_columns(work, console);
  IdentifyOptions options;
  const std::vector<RangeResult> ranges = identify_ranges(work, columns, arguments, options, console);
  refuse_warnings(arguments, console);
  const std::string report = report_text(ranges);
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
  Work work = prepare_work(config_of(arguments), arguments, console);
  compile_libraries(work);
  const std::vector<Columns> columns = all_columns(work, console);
  std::string text;
  std::vector<dsp::Check> checks;
  for (const Input& input : work.inputs) {
    for (const dsp::Check& check : input.prepared.checks) {
      checks.push_back(check);
      text += fmt::format("{:<8} {}: {}: {}\n", to_string(check.status), input.prepared.name, check.name,
                          printable(check.message));
    }
  }
  for (const Range& range : work.config.ranges) {
    const RangeRows rows = range_rows(range, columns);
    text += fmt::format("{:<8} range {}: {} training rows, {} test rows\n", "ok", range.spec.name, rows.train.size(),
                        rows.test.size());
  }
  console.result(console.json() ? checks_json(checks) : text);
}

}  // namespace apps
