#include <fmt/format.h>

#include <memory>

#include "apps/cli/run_arguments.hpp"
#include "apps/output/results_json.hpp"
#include "apps/output/run_folder.hpp"

namespace apps {
namespace {

int prepare(const RunArguments& arguments, Console& console) {
  const Config config = config_of(arguments);
  if (arguments.dry_run) {
    console.result(plan_text(arguments, config));
    return 0;
  }
  RunFolder results(folder_apart(arguments, config, "-run"), arguments.force, origin_of(arguments, "prep", config));
  HashesBeside hashes(input_files(config), arguments.num_threads);
  const Work work = prepare_work(config, arguments, console);
  results.add_files(work.inputs, hashes);
  results.finish(work.config, work.inputs, steady_steps(work.inputs), console);
  console.result(console.json() ? quality_json(work.inputs)
                                : fmt::format("prepared signals are in {}\n", results.destination().string()));
  return 0;
}

}  // namespace

Command prepare_command() {
  const auto typed = std::make_shared<RunArguments>();
  return {.name = "prep",
          .help = "Clean signals only: calibration, decimation, motion, regimes",
          .group = identify_group,
          .options = run_options(*typed),
          .run = [typed](const GlobalOptions& global,
                         Console& console) { return prepare(with_global(*typed, global), console); },
          .examples = {"ardent prep drive.wav -o drive-prep", "ardent prep drive.toml --set prepare.rate_hz=256"}};
}

}  // namespace apps
