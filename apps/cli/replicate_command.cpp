#include "apps/cli/replicate_command.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <memory>

#include "apps/cli/command.hpp"
#include "apps/config/parameter_settings.hpp"
#include "apps/output/output_folder.hpp"
#include "apps/paper/replicate.hpp"

namespace apps {
namespace {

[[noreturn]] void refuse(const char* name, const std::string& text) {
  throw dsp::Fault(dsp::FaultKind::usage, name, "replicate: " + text);
}

ReplicateOptions options_of(const ReplicateArguments& arguments) {
  if (arguments.num_seeds < 1)
    refuse("replicate.seeds", fmt::format("--seeds {}, want 1 or more", arguments.num_seeds));
  const double noise = require_within(arguments.noise.value_or(stated_noise()), 0.0, most_noise, "replicate.noise",
                                      "replicate: --noise");
  ReplicateOptions options{arguments.num_seeds, arguments.first_seed, noise};
  bool known = false;
  for (const auto selection : {ident::Selection::evidence, ident::Selection::evidence_white, ident::Selection::type2})
    if (arguments.selection == to_string(selection)) options.selection = selection, known = true;
  if (!known)
    refuse("replicate.selection",
           fmt::format("--selection '{}', want evidence-white, evidence or type2", arguments.selection));
  if (arguments.tau && !(*arguments.tau >= 0.0 && std::isfinite(*arguments.tau)))
    refuse("replicate.tau", fmt::format("--tau {}, want 0 or more", *arguments.tau));
  options.tau = arguments.tau.value_or(-1.0);
  return options;
}

}  // namespace

void run_replicate(const ReplicateArguments& arguments, Console& console) {
  const ReplicateOptions options = options_of(arguments);
  require_items(arguments.items);
  const auto start = std::chrono::steady_clock::now();
  OutputFolder folder(arguments.folder, arguments.force);
  Manifest manifest = begin_manifest("replicate", arguments.command_line, arguments.first_seed, folder.destination());
  ReplicateOptions rig_options = options;
  rig_options.noise = arguments.noise.value_or(1.0);
  const Replicated replicated = replicate(arguments.items, options, rig_options, folder, console);
  folder.commit(std::move(manifest));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  console.result(console.json() ? replicated.json
                                : replicated.summary + fmt::format("in {:.1f} s; open {}\n", seconds,
                                                                   (folder.destination() / "replicate.html").string()));
}

Command replicate_command() {
  const auto typed = std::make_shared<ReplicateArguments>();
  return {.name = "replicate",
          .help = "Computes the paper's tables and figures again, beside the printed numbers",
          .group = made_group,
          .unused = {{"--dry-run"}, {"--seed", ", or give --first-seed"}, {"--set"}, {"--threads"}},
          .options = {{"ITEM",
                       &typed->items,
                       "A case (duffing, coulomb, bouc-wen, bouc-wen-2, valanis-1 ... valanis-4, qzs-low, qzs-high, "
                       "qzs-mixed, qzs), table-1 ... table-12, fig-2 ... fig-9, fig-11 ... fig-13, all.",
                       {.required = true}},
                      {"--seeds",
                       &typed->num_seeds,
                       "How many draws of the noise.",
                       {.preset = std::to_string(typed->num_seeds), .check = whole_number(1, 1'000'000)}},
                      {"--first-seed",
                       &typed->first_seed,
                       "The first of them.",
                       {.preset = std::to_string(typed->first_seed), .check = whole_number(0)}},
                      {"--noise", &typed->noise,
                       "Fraction of each target's standard deviation (0.1); qzs: times the sensors' own (1)."},
                      {"--selection",
                       &typed->selection,
                       "evidence-white, evidence or type2 (the paper's).",
                       {.preset = typed->selection}},
                      {"--tau", &typed->tau, "Gain of evidence above which a term is kept."}},
          .run =
              [typed](const GlobalOptions& global, Console& console) {
                ReplicateArguments arguments = *typed;
                arguments.folder = required_output(global, "replicate");
                arguments.force = global.force;
                arguments.command_line = global.command_line;
                run_replicate(arguments, console);
                return 0;
              },
          .examples = {"ardent replicate all -o paper", "ardent replicate table-9 fig-13 -o rig --seeds 5"}};
}

}  // namespace apps
