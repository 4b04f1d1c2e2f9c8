#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "apps/cli/run_arguments.hpp"
#include "apps/output/output_folder.hpp"
#include "apps/output/study_output.hpp"
#include "apps/page/outcome_pages.hpp"
#include "dsp/io/read_recording.hpp"
#include "dsp/values/names.hpp"

namespace apps {
namespace {

namespace fs = std::filesystem;

struct StudyArguments {
  RunArguments run;               ///< input, folder and what a run takes
  std::vector<std::string> over;  ///< "KEY=V1,V2,..."; none: the config's [study], else default_axes
  bool grid = false;              ///< every combination instead of one setting at a time
};

/// `first`: of the recordings.
std::vector<StudyAxis> axes_of(const StudyArguments& arguments, Config config, const dsp::RecordingReader& first,
                               Console& console) {
  if (arguments.over.empty() && !config.study.empty()) return config.study;
  std::vector<StudyAxis> axes;
  for (const std::string& text : arguments.over) axes.push_back(parse_axis(text));
  if (!axes.empty()) return axes;
  choose_band(config, arguments.run.max_memory_bytes, console);
  return default_axes(config, first.description().sample_rate_hz, first.num_frames());
}

/// The longest list of ranges any cell has.
std::vector<std::string> range_names(const std::vector<StudyResult>& results) {
  std::vector<std::string> names;
  for (const StudyResult& result : results)
    for (std::size_t i = names.size(); i < result.ranges.size(); ++i) names.push_back(result.ranges[i].name);
  return names;
}

bool kept_nothing(const std::vector<StudyResult>& results) {
  for (const StudyResult& result : results)
    for (const StudyRange& range : result.ranges)
      for (const ident::JudgedFit& fit : range.fits)
        if (!fit.model.terms.empty()) return false;
  return true;
}

/// Writes study.txt, study.csv, study.json, study.html and study-RANGE.svg into the folder. 4 where no cell kept a
/// term, else 0.
int study(const StudyArguments& arguments, Console& console) {
  const RunArguments& run = arguments.run;
  const Config config = config_of(run);
  const fs::path destination = folder_apart(run, config, "-study");
  const dsp::RecordingReader first(config.recordings.front().file,
                                   read_options(config.recordings.front(), run.max_memory_bytes));
  const std::vector<StudyAxis> asked = axes_of(arguments, config, first, console);
  const auto config_with = [&run](const std::vector<std::string>& overrides) {
    RunArguments cell = run;
    cell.set.insert(cell.set.end(), overrides.begin(), overrides.end());
    return config_of(cell);
  };
  const StudyRequest request{.config_with = config_with,
                             .cells = study_cells(asked, arguments.grid),
                             .sample_rate_hz = first.description().sample_rate_hz,
                             .max_memory_bytes = run.max_memory_bytes,
                             .num_threads = run.num_threads,
                             .strict = run.strict};
  if (run.dry_run) {
    std::string text;
    for (const StudyCell& cell : request.cells) text += cell.label() + "\n";
    console.result(text + fmt::format("would write {}\n", destination.string()));
    return 0;
  }
  OutputFolder folder(destination, run.force);
  Manifest manifest = begin_manifest("study", run.command_line, run.seed, folder.destination());
  std::vector<fs::path> inputs = input_files(config);
  if (run.input.extension() == ".toml") inputs.push_back(run.input);
  for (const fs::path& input : inputs) add_input(manifest, input, folder.destination());
  const std::vector<StudyResult> results = run_cells(request, console);
  const std::string text = study_text(results, asked), json = study_json(results, asked);
  folder.write("study.txt", text);
  folder.write("study.csv", study_csv(results));
  const auto names = range_names(results);
  for (std::size_t i = 0; i < names.size(); ++i)
    folder.write(fmt::format("study-{}.svg", dsp::slug(names[i])), to_svg(study_figure(results, asked, i)));
  folder.write("study.html", study_page(results, asked, names));
  folder.write("study.json", json);
  manifest.warnings = console.warnings();
  folder.commit(std::move(manifest));
  console.result(console.json() ? json : fmt::format("{}\nresults are in {}\n", text, folder.destination().string()));
  if (!kept_nothing(results)) return 0;
  console.error("fit.nothing_selected",
                "no setting selected a term. Give other candidates, or lower fit.tau or fit.threshold.");
  return 4;
}

}  // namespace

Command study_command() {
  const auto typed = std::make_shared<StudyArguments>();
  return {.name = "study",
          .help = "How an identification depends on its settings",
          .group = identify_group,
          .options = joined(run_options(typed->run),
                            {{"--over",
                              &typed->over,
                              "Values of one setting; may be repeated. KEY is order, cutoff_hz, rolloff_hz, tau, "
                              "threshold, selection, recipe, train_share, target, or any key of a config.",
                              {.name = "KEY=V1,V2,..."}},
                             {"--grid", &typed->grid, "Try every combination instead of one setting at a time."}}),
          .run =
              [typed](const GlobalOptions& global, Console& console) {
                StudyArguments arguments = *typed;
                arguments.run = with_global(arguments.run, global);
                return study(arguments, console);
              },
          .examples = {"ardent study drive.toml -o drive-study",
                       "ardent study drive.toml --over order=1,2,3 --over tau=5,20,80 --grid"}};
}

}  // namespace apps
