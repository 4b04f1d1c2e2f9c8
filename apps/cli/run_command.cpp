#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/cli/repeat_run.hpp"
#include "apps/cli/run_job.hpp"
#include "apps/page/first_screen.hpp"

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
  RunFolder results(folder_apart(arguments, config, "-run"), arguments.force, origin_of(arguments, "run", config));
  const RunOutcome outcome = run_into(results, config, arguments, console);
  console.result(console.json()
                     ? outcome.equation
                     : fmt::format("{0}{1:<{2}}results are in {3}: open report.html, or ardent report {3} --details\n",
                                   outcome.report, "more", label_width, results.destination().string()));
  return outcome.exit_code;
}

}  // namespace

Command run_command() {
  return {
      "run",
      "From a recording to its equation of motion",
      {},
      [](CLI::App& command) -> CommandBody {
        const auto run_arguments = add_run_arguments(command);
        auto require = std::make_shared<std::string>();
        auto full = std::make_shared<bool>(false);
        command
            .add_option(
                "--require", *require,
                "Exit code 4 unless the verdict on every range is this or better. Results are written in either case.")
            ->option_text("VERDICT")
            ->check(CLI::IsMember({"describes", "in_part"}));
        command.add_flag("--full", *full,
                         "Write tables with every row and digit, even if the run folder becomes larger than its "
                         "recording and 10 MB.");
        return [=](const GlobalOptions& global, Console& console) {
          RunArguments arguments = run_arguments(global);
          arguments.require = *require;
          arguments.full = *full;
          return run(arguments, console);
        };
      },
      identify_group,
      {"ardent run drive.wav", "ardent run drive.toml -o drive-run --set fit.train_share=0.5",
       "ardent run monday.csv --sidecar rig.toml --require describes",
       "ardent run drive-run   # a run again, compared"},
      "INPUT is a recording, a config that names one or several, or the folder of an earlier run. An earlier run is "
      "repeated from its config.toml in a temporary folder (or in the one that -o names) and compared: exit code 0 if "
      "inputs, program and results are the same, bit for bit; 3 if an input has changed; 4 if only results differ."};
}

}  // namespace apps
