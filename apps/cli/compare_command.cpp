#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "apps/cli/command.hpp"
#include "apps/output/bodies_file.hpp"
#include "apps/output/finished_run.hpp"
#include "apps/output/output_folder.hpp"
#include "apps/output/run_comparison.hpp"
#include "apps/page/comparison_page.hpp"
#include "dsp/values/fault.hpp"

namespace apps {
namespace {

struct CompareArguments {
  std::vector<std::filesystem::path> runs;
  std::filesystem::path truth;
  std::string method = "fast_rvm";
};

/// Text, document and page of a comparison.
void write_comparison(const CompareArguments& arguments, const RunComparison& comparison, const GlobalOptions& global,
                      Console& console) {
  std::vector<std::filesystem::path> inputs = arguments.runs;
  if (!arguments.truth.empty()) inputs.push_back(arguments.truth);
  require_apart(global.output, inputs);
  OutputFolder folder(global.output, global.force);
  Manifest manifest = begin_manifest("compare", global.command_line, global.seed, folder.destination());
  for (const std::filesystem::path& run : arguments.runs)
    add_input(manifest, run / (is_bodies_run(run) ? "equation.json" : "metrics.json"), folder.destination());
  if (!arguments.truth.empty()) add_input(manifest, arguments.truth, folder.destination());
  const std::vector<PlotFigure> figures = comparison_figures(comparison);
  for (const PlotFigure& figure : figures)
    write_figure_files(figure, [&](const std::string& name, std::string_view bytes) { folder.write(name, bytes); });
  folder.write("compare.txt", to_text(comparison));
  folder.write("compare.json", to_json(comparison));
  folder.write("compare.html", comparison_page(comparison, figures));
  manifest.warnings = console.warnings();
  folder.commit(std::move(manifest));
  console.step(fmt::format("results are in {}: open compare.html", folder.destination().string()));
}

int compare(const CompareArguments& arguments, const GlobalOptions& global, Console& console) {
  if (global.force && global.output.empty())
    throw dsp::Fault(dsp::FaultKind::usage, "usage", "compare: --force has no effect without -o DIR. Leave it out");
  for (const auto& run : arguments.runs) check_finished_run(run, global.strict, console);
  const RunComparison comparison = compare_runs(arguments.runs, arguments.truth, arguments.method);
  if (!global.output.empty()) write_comparison(arguments, comparison, global, console);
  console.result(console.json() ? to_json(comparison) : to_text(comparison));
  return 0;
}

}  // namespace

Command compare_command() {
  const auto typed = std::make_shared<CompareArguments>();
  return {
      .name = "compare",
      .help = "What changed between runs, and their equations side by side",
      .group = use_group,
      .unused = {{"--seed"}, {"--dry-run"}, {"--set"}, {"--threads"}},
      .options =
          {{"RUN", &typed->runs, "Run folders.", {.required = true}},
           {"--truth", &typed->truth, "truth.json of the simulation that the recording came from.", {.name = "FILE"}},
           {"--method", &typed->method, "Method whose equation is shown.", {.preset = typed->method}}},
      .run = [typed](const GlobalOptions& global, Console& console) { return compare(*typed, global, console); },
      .examples = {"ardent compare monday-run tuesday-run -o monday-tuesday", "ardent compare out/* --method sindy"},
      .details =
          "With -o DIR the comparison is also written into a folder: compare.html, the page with a figure of every "
          "coefficient, compare.txt, compare.json and figures/."};
}

}  // namespace apps
