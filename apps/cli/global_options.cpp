#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <thread>

#include "apps/cli/command.hpp"
#include "apps/cli/option_values.hpp"
#include "apps/process/version.hpp"
#include "dsp/fault.hpp"

namespace apps {

void add_global_options(CLI::App& app, GlobalOptions& options) {
  app.add_option("-o,--output", options.output, "Folder for the results")->type_name("DIR");
  app.add_flag("-q,--quiet", options.quiet, "Results and errors only");
  app.add_flag("-v,--verbose", options.verbosity, "Notes too");
  app.add_flag("--json", options.json, "One JSON document on standard output");
  app.add_option("--seed", options.seed, "Seed of whatever is random")->transform(whole(0))->capture_default_str();
  app.add_option("--threads", options.num_threads,
                 "Threads; 0: as many as there are processors. The results are the same")
      ->transform(whole(0, 1024))
      ->option_text("INT=0");
  app.add_flag("--dry-run", options.dry_run, "Say what would be done");
  app.add_flag("--force", options.force, "Replace an earlier result");
  app.add_flag("--strict", options.strict, "Warnings are errors");
  app.add_option("--set", options.set, "Override a setting: a.b=c")->type_name("KEY=VALUE")->allow_extra_args(false);
  const std::map<std::string, ProgressMode> modes{
      {"auto", ProgressMode::automatic}, {"always", ProgressMode::always}, {"never", ProgressMode::never}};
  app.add_option("--progress", options.progress, "auto (on a terminal), always or never")
      ->transform(CLI::CheckedTransformer(modes))
      ->option_text("WHEN=auto");
  app.set_version_flag("--version", version_text());
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
