#include "apps/cli/study_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "apps/config/inputs.hpp"
#include "apps/output/study_output.hpp"
#include "apps/process/output_folder.hpp"
#include "dsp/names.hpp"

namespace apps {
namespace {

namespace fs = std::filesystem;

std::vector<StudyAxis> axes_of(const StudyArguments& arguments, const Config& config, double rate_hz) {
  if (arguments.over.empty()) return config.study.empty() ? default_axes(config, rate_hz) : config.study;
  std::vector<StudyAxis> axes;
  for (const std::string& text : arguments.over) axes.push_back(parse_axis(text));
  return axes;
}

fs::path folder_of(const RunArguments& run, const Config& config) {
  const fs::path folder = run.folder.empty() ? fs::path(dsp::slug(run.input.stem().string()) + "-study") : run.folder;
  std::vector<fs::path> inputs = input_files(config);
  inputs.push_back(run.input);
  require_apart(folder, inputs);
  return folder;
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
    for (const ident::StudyRange& range : result.ranges)
      for (const ident::JudgedFit& fit : range.fits)
        if (!fit.model.terms.empty()) return false;
  return true;
}

}  // namespace

int run_study(const StudyArguments& arguments, Console& console) {
  const RunArguments& run = arguments.run;
  const auto adjust = [&run](Config& config) {
    for (RecordingConfig& recording : config.recordings) {
      recording.salvage = recording.salvage || run.salvage;
      recording.uncalibrated = recording.uncalibrated || run.uncalibrated;
    }
  };
  Config config = read_config(run.input, run.set);
  adjust(config);
  const fs::path place = folder_of(run, config);
  const double rate_hz = dsp::RecordingReader(config.recordings.front().file,
                                              read_options(config.recordings.front(), run.max_memory_bytes))
                             .description()
                             .sample_rate_hz;
  const std::vector<StudyAxis> axes = axes_of(arguments, config, rate_hz);
  StudyRequest request{
      run.input,       run.set,   adjust, study_cells(axes, arguments.grid), rate_hz, run.max_memory_bytes,
      run.num_threads, run.strict};
  if (run.dry_run) {
    std::string text;
    for (const StudyCell& cell : request.cells) text += cell.label() + "\n";
    console.result(text + fmt::format("would write {}\n", place.string()));
    return 0;
  }
  OutputFolder folder(place, run.force);
  Manifest manifest = begin_manifest("study", run.command_line, run.seed, folder.destination());
  std::vector<fs::path> inputs = input_files(config);
  if (run.input.extension() == ".toml") inputs.push_back(run.input);
  for (const fs::path& input : inputs) add_input(manifest, input, folder.destination());
  const std::vector<StudyResult> results = run_cells(request, console);
  const std::string text = study_text(results, axes), json = study_json(results, axes);
  folder.write("study.txt", text);
  folder.write("study.csv", study_csv(results));
  const auto names = range_names(results);
  for (std::size_t i = 0; i < names.size(); ++i)
    folder.write(fmt::format("study-{}.svg", dsp::slug(names[i])), study_figure(results, axes, i));
  folder.write("study.json", json);
  manifest.warnings = console.warnings();
  folder.commit(std::move(manifest));
  console.result(console.json() ? json : fmt::format("{}\nresults are in {}\n", text, folder.destination().string()));
  if (!kept_nothing(results)) return 0;
  console.error("fit.nothing_selected",
                "no setting selected a term. Give other candidates, or lower fit.tau or fit.threshold.");
  return 4;
}

}  // namespace apps
