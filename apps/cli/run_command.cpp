#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "apps/cli/repeat_run.hpp"
#include "apps/cli/run_job.hpp"
#include "apps/output/run_json.hpp"
#include "apps/output/staging_folder.hpp"
#include "apps/page/first_screen.hpp"
#include "apps/process/path.hpp"

namespace apps {
namespace {

/// Recording to judged equation: the run folder, and the equations on the console.
int run(const RunArguments& arguments, Console& console) {
  if (is_finished_run(arguments.input)) return repeat_run(arguments, console);
  const Config config = config_of(arguments);
  if (arguments.dry_run) {
    console.result(plan_text(arguments, config));
    return 0;
  }
  const std::filesystem::path folder = folder_apart(arguments, config, "-run");
  const RunFolder::Origin origin = origin_of(arguments, "run", config);
  if (arguments.resume)
    if (const std::optional<int> code = kept_exit_code(folder, config, origin)) {
      { const StagingFolder leftovers(named_path(folder)); }  // of a command killed right behind its end: they go
      console.step(fmt::format("{} holds this run already", folder.string()));
      console.result(read_run_file(folder / (console.json() ? "equation.json" : "equation.txt")));
      return *code;
    }
  RunFolder results(folder, arguments.force || arguments.resume, origin);
  const RunOutcome outcome = run_into(results, config, arguments, console);
  console.result(console.json()
                     ? outcome.equation
                     : fmt::format("{0}{1:<{2}}results are in {3}: open report.html, or ardent report {3} --details\n",
                                   outcome.report, "more", label_width, results.destination().string()));
  return outcome.exit_code;
}

}  // namespace

Command run_command() {
  const auto typed = std::make_shared<RunArguments>();
  return {
      .name = "run",
      .help = "From a recording to its equation of motion",
      .group = identify_group,
      .options =
          joined(joined(run_options(*typed),
                        {{"RECORDING",
                          &typed->recording,
                          "To be identified with the settings of the config INPUT.",
                          {.is_recording = true}},
                         {"--require",
                          &typed->require,
                          "Exit code 4 unless the verdict on every range is this or better. Results are written in "
                          "either case.",
                          {.name = "VERDICT", .words = {"describes", "in_part"}}},
                         {"--resume", &typed->resume,
                          "Leave a folder as it is that holds this very run: the same inputs, settings and program. "
                          "Replace one that holds another."}}),
                 less_options(*typed)),
      .run = [typed](const GlobalOptions& global,
                     Console& console) { return run(with_global(*typed, global), console); },
      .examples = {"ardent run drive.wav", "ardent run drive.toml -o drive-run --set fit.train_share=0.5",
                   "ardent run monday.csv --sidecar rig.toml --require describes",
                   "ardent run rig.toml monday.csv   # the settings of rig.toml",
                   "ardent run drive-run   # a run again, compared"},
      .details =
          "INPUT is a recording, a config that names one or several, or the folder of an earlier run. An earlier run "
          "is repeated from its config.toml in a temporary folder (or in the one that -o names) and compared: exit "
          "code 0 if inputs, program and results are the same, bit for bit; 3 if an input has changed; 4 if only "
          "results differ."};
}

}  // namespace apps
