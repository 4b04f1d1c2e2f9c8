#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <thread>

#include "apps/cli/command.hpp"
#include "dsp/values/fault.hpp"

namespace apps {
namespace {

/// The options that may stand anywhere on the command line.
std::vector<Option> global_options(GlobalOptions& global) {
  const auto take_progress = [&global](const std::string& when) {
    global.progress = when == "always"  ? ProgressMode::always
                      : when == "never" ? ProgressMode::never
                                        : ProgressMode::automatic;
  };
  return {{"-o,--output", &global.output, "Folder for the results.", {.name = "DIR"}},
          {"--set",
           &global.set,
           "Give a setting another value; may be repeated. What can be set: ardent help config, or below.",
           {.name = "KEY=VALUE"}},
          {"--force", &global.force, "Replace an earlier result."},
          {"--dry-run", &global.dry_run, "Print what would be done, without doing it."},
          {"--strict", &global.strict, "Stop at the first warning, with exit code 3."},
          {"--seed",
           &global.seed,
           "Seed of random numbers.",
           {.preset = std::to_string(global.seed), .check = whole_number(0)}},
          {"--threads",
           &global.num_threads,
           "Threads; 0: as many as there are processors. The results are the same.",
           {.name = "N", .preset = "0", .check = whole_number(0, 1024)}},
          {"--json", &global.json, "Print one JSON document on standard output."},
          {"-q,--quiet", &global.quiet, "Print results and errors only."},
          {"-v,--verbose", &global.verbose, "Print notes, too."},
          {"--progress",
           take_progress,
           "Draw progress: auto (on a terminal), always or never.",
           {.name = "WHEN", .preset = "auto", .words = {"always", "auto", "never"}}}};
}

}  // namespace

Program make_program() {
  Program program{std::make_shared<GlobalOptions>(), {}, {}};
  const Option help{"-h,--help", {}, "Print this page."};
  const std::vector<Option> global = global_options(*program.global);
  program.options = joined({{"--version", {}, "Print the versions of the program and its libraries."}}, global);
  program.options.push_back(help);
  program.commands = {info_command(),      check_command(), init_command(),     run_command(),        prepare_command(),
                      study_command(),     batch_command(), report_command(),   compare_command(),    predict_command(),
                      export_command(),    merge_command(), response_command(), simulate_command(),   fit_command(),
                      replicate_command(), terms_command(), help_command(),     completion_command(), manual_command()};
  for (Command& command : program.commands) {
    const auto takes = [&](const Option& option) {
      return std::none_of(command.unused.begin(), command.unused.end(),
                          [&](const UnusedOption& unused) { return option.names.ends_with(unused.name); });
    };
    std::copy_if(global.begin(), global.end(), std::back_inserter(command.options), takes);
    command.options.push_back(help);
  }
  return program;
}

std::vector<Option> joined(std::vector<Option> options, const std::vector<Option>& more) {
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

int thread_count(const GlobalOptions& options) {
  return options.num_threads > 0 ? options.num_threads
                                 : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

std::filesystem::path required_output(const GlobalOptions& options, const char* command) {
  if (options.output.empty())
    throw dsp::Fault(dsp::FaultKind::usage, "usage",
                     fmt::format("{}: -o DIR is missing. Say where the files are to go", command));
  return options.output;
}

}  // namespace apps
