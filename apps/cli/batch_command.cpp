#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "apps/batch/batch_folder.hpp"
#include "apps/batch/batch_page.hpp"
#include "apps/batch/ranks.hpp"
#include "apps/batch/record_runs.hpp"
#include "apps/cli/run_arguments.hpp"
#include "apps/config/identification.hpp"
#include "apps/output/factors_file.hpp"
#include "apps/output/joint_report.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/process/printable.hpp"
#include "dsp/values/for_each_index.hpp"

namespace apps {
namespace {

namespace fs = std::filesystem;

struct BatchArguments {
  RunArguments run;  ///< input: the config, if there is one; folder: of the batch
  std::vector<fs::path> recordings;
  int num_jobs = 0;     ///< at a time; 0: one a processor, under mpirun one a process
  int num_threads = 0;  ///< of each run; 0: what processors there are for the jobs
};

/// What `ardent run` is given for each recording.
std::vector<std::string> options_of_runs(const BatchArguments& arguments, int num_threads) {
  const RunArguments& run = arguments.run;
  std::vector<std::string> options{
      "-q", "--progress", "never", "--threads", std::to_string(num_threads), run.force ? "--force" : "--resume"};
  const auto flag = [&](bool is_set, const char* name) {
    if (is_set) options.emplace_back(name);
  };
  flag(run.strict, "--strict");
  flag(run.salvage, "--salvage");
  flag(run.uncalibrated, "--uncalibrated");
  flag(run.no_rows, "--no-rows");
  flag(run.no_figures, "--no-figures");
  const auto value = [&](const char* name, const std::string& text) { options.insert(options.end(), {name, text}); };
  if (!run.sidecar.empty()) value("--sidecar", run.sidecar.string());
  if (run.max_memory_bytes > 0) value("--max-memory", std::to_string(run.max_memory_bytes / 1000000));
  value("--seed", std::to_string(run.seed));
  for (const std::string& setting : run.set) value("--set", setting);
  return options;
}

int processors_here() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

RecordRuns::Options run_options_of(const BatchArguments& arguments, const Ranks* ranks) {
  const int processors = processors_here();
  const int jobs = arguments.num_jobs > 0 ? arguments.num_jobs : ranks != nullptr ? 1 : processors;
  const int threads = arguments.num_threads > 0 ? arguments.num_threads
                      : ranks != nullptr        ? 1
                                                : std::max(1, processors / jobs);
  return {arguments.run.input, arguments.run.folder / BatchFolder::runs_name, options_of_runs(arguments, threads),
          jobs};
}

/// The config, for the first recording: what is wrong with it is said before anything is started.
Config checked_config(const BatchArguments& arguments) {
  RunArguments first = arguments.run;
  const auto is_file = [](const fs::path& path) {
    std::error_code unknown;
    return !fs::is_directory(path, unknown);  // which costs that record only
  };
  const auto& all = arguments.recordings;
  const auto usable = std::find_if(all.begin(), all.end(), is_file);
  (first.input.empty() ? first.input : first.recording) = usable == all.end() ? all.front() : *usable;
  Config config = config_of(first);
  check_library(config);
  std::vector<fs::path> inputs = arguments.recordings;
  if (!arguments.run.input.empty()) inputs.push_back(arguments.run.input);
  require_apart(arguments.run.folder, inputs);
  return config;
}

/// A config that comes before the recordings.
void take_config(BatchArguments& arguments) {
  std::vector<fs::path>& recordings = arguments.recordings;
  const auto is_config = [](const fs::path& path) { return path.extension() == ".toml"; };
  const auto late = std::find_if(recordings.begin() + 1, recordings.end(), is_config);
  if (late != recordings.end())
    throw dsp::Fault(dsp::FaultKind::usage, "usage",
                     fmt::format("{}: want one config, before the recordings", late->string()));
  if (!is_config(recordings.front())) return;
  arguments.run.input = std::move(recordings.front());
  recordings.erase(recordings.begin());
  if (recordings.empty())
    throw dsp::Fault(dsp::FaultKind::usage, "usage",
                     fmt::format("{}: want recordings after the config. What it names itself: ardent run {}",
                                 arguments.run.input.string(), arguments.run.input.string()));
}

/// Runs in the folder that a summary of these recordings would leave out.
void require_all_of_before(const BatchArguments& arguments, const std::vector<RecordTask>& tasks) {
  if (arguments.run.force) return;
  std::vector<std::string> others;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(arguments.run.folder / BatchFolder::runs_name, none)) {
    const std::string name = entry.path().filename().string();
    const bool is_named =
        std::any_of(tasks.begin(), tasks.end(), [&](const RecordTask& task) { return task.name == name; });
    if (!is_named && fs::exists(entry.path() / manifest_name, none)) others.push_back(printable(name, 60));
  }
  if (others.empty()) return;
  std::sort(others.begin(), others.end());
  const std::size_t count = others.size();
  constexpr std::size_t most = 3;
  if (count > most) others.resize(most), others.emplace_back("...");
  throw dsp::Fault(dsp::FaultKind::output, "batch.others",
                   fmt::format("{}: has {} run{} of recordings that are not named now ({}). Name them, too, or -o "
                               "another folder; --force leaves them out of the summary",
                               arguments.run.folder.string(), count, count == 1 ? "" : "s", fmt::join(others, ", ")));
}

std::string plan(const std::vector<RecordTask>& tasks, const RecordRuns::Options& runs) {
  std::string text;
  for (const std::size_t i : longest_first(tasks))
    text += fmt::format("{} -> {}\n", tasks[i].recording.string(), (runs.runs / tasks[i].name).string());
  return text + fmt::format("{} at a time in each process\n", runs.num_jobs);
}

/// Runs all tasks here and on the other ranks.
std::vector<TaskOutcome> run_all(const std::vector<RecordTask>& tasks, const RecordRuns::Options& options, Ranks* ranks,
                                 Console& console) {
  std::vector<TaskOutcome> outcomes(tasks.size());
  double all = 0.0, bytes = 0.0;
  std::size_t count = 0;
  for (const RecordTask& task : tasks) all += 1.0 + static_cast<double>(task.bytes);
  const auto note = [&](TaskOutcome outcome) {
    const RecordTask& task = tasks.at(outcome.task);
    bytes += 1.0 + static_cast<double>(task.bytes);
    if (!outcome.error.empty()) console.warning("batch.record", fmt::format("{}: {}", task.called, outcome.error));
    console.progress(fmt::format("{} of {} records", ++count, tasks.size()), bytes / all);
    outcomes[outcome.task] = std::move(outcome);
  };
  console.progress(fmt::format("0 of {} records", tasks.size()), 0.0);
  RecordRuns runs(options, tasks);
  deal_tasks(longest_first(tasks), runs, ranks, note, check_interrupted);
  return outcomes;
}

BatchResults results_of(const std::vector<RecordTask>& tasks, const std::vector<TaskOutcome>& outcomes,
                        const BatchArguments& arguments, const Config& config, const RecordRuns::Options& runs,
                        int num_threads) {
  BatchResults results{.config = arguments.run.input.filename().string(), .header = config.report, .records = {}};
  results.records.resize(tasks.size());
  dsp::for_each_index(tasks.size(), num_threads, [&](std::size_t i) {
    check_interrupted();
    results.records[i] = record_result(tasks[i], outcomes[i], runs.runs, arguments.run.require);
  });
  std::vector<std::vector<ident::RecordFactors>> of_runs;
  std::vector<fs::path> names;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    of_runs.push_back(std::exchange(results.records[i].factors, {}));
    names.emplace_back(tasks[i].name);
  }
  const std::vector<ident::RecordFactors> factors = name_apart(std::move(of_runs), names);
  if (factors.empty()) {
    results.joint_reason = "no record has R factors";
    return results;
  }
  results.warnings = differences(factors);
  try {
    results.joint = joint_fits(factors, config.fit.settings.options_of(config.fit.methods), check_interrupted);
  } catch (const dsp::Fault& fault) {
    results.joint_reason = fault.what();
  }
  return results;
}

/// Sends the other ranks home, unless they have gone.
void dismiss(std::unique_ptr<Ranks>& ranks) {
  if (ranks == nullptr) return;
  send_home(*ranks);
  ranks->finish();
  ranks.reset();
}

/// That of the first record, in the order given, that ended with one.
int exit_code_of(const std::vector<RecordResult>& records) {
  const auto failed =
      std::find_if(records.begin(), records.end(), [](const RecordResult& record) { return record.exit_code != 0; });
  return failed == records.end() ? 0 : failed->exit_code;
}

int write_results(const BatchResults& results, const BatchArguments& arguments, BatchFolder& folder, Manifest manifest,
                  Console& console) {
  const std::string json =
      table_json(results.records, results.joint.empty() ? "" : joint_json(results.joint), results.joint_reason);
  for (const std::string& warning : results.warnings) console.warning("factors.differ", warning);
  folder.write("table.csv", table_csv(results.records));
  folder.write("table.json", json);
  folder.write("report.html", batch_page(results));
  folder.write("log.txt", console.log());
  if (!arguments.run.input.empty()) add_input(manifest, arguments.run.input, folder.destination());
  manifest.warnings = console.warnings();
  manifest.exit_code = exit_code_of(results.records);
  const int code = manifest.exit_code;
  folder.commit(std::move(manifest));
  const auto kept = std::count_if(results.records.begin(), results.records.end(),
                                  [](const RecordResult& record) { return record.was_kept; });
  console.result(console.json() ? json
                                : fmt::format("{}{}results are in {}: open report.html\n", batch_text(results),
                                              kept > 0 ? fmt::format("{} kept from before; ", kept) : "",
                                              folder.destination().string()));
  return code;
}

/// What rank 0 does, or the only process there is. `ranks` is null once the others have gone home.
int lead(const BatchArguments& arguments, std::unique_ptr<Ranks>& ranks, Console& console) {
  const Config config = checked_config(arguments);
  const std::vector<RecordTask> tasks = record_tasks(arguments.recordings);
  const RecordRuns::Options runs = run_options_of(arguments, ranks.get());
  if (arguments.run.dry_run) {
    console.result(plan(tasks, runs));
    return 0;
  }
  require_all_of_before(arguments, tasks);
  BatchFolder folder(arguments.run.folder);
  Manifest manifest = begin_manifest("batch", arguments.run.command_line, arguments.run.seed, folder.destination());
  std::vector<TaskOutcome> outcomes;
  try {
    outcomes = run_all(tasks, runs, ranks.get(), console);
  } catch (const Interrupted&) {
    console.step(fmt::format("runs that are complete stay in {}; the same command goes on there", runs.runs.string()));
    throw;
  }
  const int num_threads = ranks != nullptr ? processors_here() : runs.num_jobs;
  dismiss(ranks);  // nobody waits while the summary is written
  console.step("writing the summary");
  return write_results(results_of(tasks, outcomes, arguments, config, runs, num_threads), arguments, folder,
                       std::move(manifest), console);
}

/// Another rank does what rank 0 gives it; what is wrong with the command line is rank 0's to say.
int follow(const BatchArguments& arguments, Ranks& ranks) {
  std::vector<RecordTask> tasks;
  try {
    tasks = record_tasks(arguments.recordings);
  } catch (const dsp::Fault&) {
  }
  RecordRuns runs(run_options_of(arguments, &ranks), tasks);
  take_tasks(runs, ranks, check_interrupted);
  ranks.finish();
  return 0;
}

int batch(const BatchArguments& arguments, Console& console) {
  std::unique_ptr<Ranks> ranks = launched_processes() > 1 ? join_ranks() : nullptr;
  if (ranks != nullptr && ranks->rank() > 0) return follow(arguments, *ranks);
  try {
    const int code = lead(arguments, ranks, console);
    dismiss(ranks);
    return code;
  } catch (const dsp::Fault&) {
    dismiss(ranks);
    throw;
  }
}

}  // namespace

Command batch_command() {
  const auto typed = std::make_shared<BatchArguments>();
  RunArguments& of_runs = typed->run;
  std::vector<Option> of_each = run_options(of_runs, "RECORDINGS", "");
  of_each.front() = {
      "RECORDINGS",
      &typed->recordings,
      "Recordings, a run each; before them a config for all, NAME.toml, if there is one (a [[recording]] "
      "in it is not run).",
      {.required = true}};
  return {
      .name = "batch",
      .help = "Many recordings, alike or by one config: on all cores, or on a cluster",
      .group = identify_group,
      .options = joined(
          joined(std::move(of_each),
                 {{"--jobs",
                   &typed->num_jobs,
                   "Runs at a time in each process; 0: one for each processor, under mpirun one.",
                   {.name = "N", .preset = "0", .check = whole_number(0, 4096)}},
                  {"--require",
                   &of_runs.require,
                   "Exit code 4 unless the verdict on every range of every record is this or better. Results are "
                   "written all the same.",
                   {.name = "VERDICT", .words = {"describes", "in_part"}}}}),
          less_options(of_runs)),
      .run =
          [typed](const GlobalOptions& global, Console& console) {
            BatchArguments arguments = *typed;
            take_config(arguments);
            arguments.run = with_global(arguments.run, global);
            arguments.num_threads = global.num_threads;
            (void)required_output(global, "batch");
            return batch(arguments, console);
          },
      .examples = {"ardent batch *.csv -o fleet", "ardent batch rig.toml *.wav -o fleet",
                   "ardent batch rig.toml *.wav -o fleet --jobs 2 --threads 1",
                   "mpirun -n 64 ardent batch rig.toml /data/*.wav -o fleet"},
      .details =
          "Each recording is run by `ardent run RECORDING`, or `ardent run CONFIG RECORDING`, in a process of its own, "
          "the largest first; its folder is DIR/runs/NAME. A recording that cannot be read, or a run that crashes or "
          "finds no memory, costs "
          "that record only: its error is in the table. At the end: table.csv and table.json, a row for each range of "
          "each record; report.html; in both what all records together say, as `ardent merge` has it. Stopped in "
          "whatever way and started again with the same command it goes on where it was: runs that are complete stay, "
          "unless their recording, sidecar or config has changed since; what failed is tried again. "
          "A folder with runs of recordings that are not named is refused without --force. Under mpirun or "
          "srun the processes share the work; the results are the same. Exit code: that of the first record, in the "
          "order given, that ended with one.",
      .starts_itself = true};
}

}  // namespace apps
