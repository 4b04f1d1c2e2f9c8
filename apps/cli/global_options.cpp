#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <thread>

#include "apps/cli/command.hpp"
#include "apps/cli/option_values.hpp"
#include "apps/process/version.hpp"
#include "dsp/fault.hpp"

namespace apps {

void add_global_options(CLI::App& app, GlobalOptions& options, const std::vector<UnusedOption>& unused) {
  const auto takes = [&](std::string_view name) {
    return std::none_of(unused.begin(), unused.end(), [&](const UnusedOption& one) { return one.name == name; });
  };
  if (takes("--output")) app.add_option("-o,--output", options.output, "Folder for the results.")->type_name("DIR");
  if (takes("--set"))
    app.add_option_function<std::vector<std::string>>(
           "--set",
           [&options](const std::vector<std::string>& given) {
             options.set.insert(options.set.end(), given.begin(), given.end());
           },
           "Give a setting another value; may be repeated. What can be set: ardent help config, or below.")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
  if (takes("--force")) app.add_flag("--force", options.force, "Replace an earlier result.");
  if (takes("--dry-run")) app.add_flag("--dry-run", options.dry_run, "Print what would be done, without doing it.");
  app.add_flag("--strict", options.strict, "Stop at the first warning, with exit code 3.");
  if (takes("--seed"))
    app.add_option("--seed", options.seed, "Seed of random numbers.")->transform(whole(0))->capture_default_str();
  if (takes("--threads"))
    app.add_option("--threads", options.num_threads,
                   "Threads; 0: as many as there are processors. The results are the same.")
        ->transform(whole(0, 1024))
        ->option_text("N")
        ->default_str("0");
  app.add_flag("--json", options.json, "Print one JSON document on standard output.");
  app.add_flag("-q,--quiet", options.quiet, "Print results and errors only.");
  app.add_flag("-v,--verbose", options.verbosity, "Print notes, too.");
  const std::map<std::string, ProgressMode> modes{
      {"auto", ProgressMode::automatic}, {"always", ProgressMode::always}, {"never", ProgressMode::never}};
  app.add_option("--progress", options.progress, "Draw progress: auto (on a terminal), always or never.")
      ->transform(CLI::CheckedTransformer(modes))
      ->option_text("WHEN")
      ->default_str("auto");
}

int thread_count(const GlobalOptions& options) {
  return options.num_threads > 0 ? options.num_threads
                                 : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

const std::filesystem::path& required_output(const GlobalOptions& options, const char* command) {
  if (options.output.empty())
    throw dsp::Fault(dsp::FaultKind::usage, "usage",
                     fmt::format("{}: -o DIR is missing. Say where the files are to go", command));
  return options.output;
}

}  // namespace apps
