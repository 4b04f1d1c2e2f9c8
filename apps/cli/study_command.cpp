#include "apps/cli/study_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "apps/config/inputs.hpp"
#include "apps/output/study_output.hpp"
#include "apps/process/atomic_file.hpp"
#include "apps/process/run_folder.hpp"
#include "apps/process/system_fault.hpp"
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
  std::error_code error;
  if (!run.force && fs::exists(folder / "study.json", error))
    throw dsp::Fault(
        dsp::FaultKind::output, "output.exists",
        fmt::format("{}: holds a study. Use --force to replace it or -o to write elsewhere", folder.string()));
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
    for (const StudyRange& range : result.ranges)
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
  const fs::path folder = folder_of(run, config);
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
    console.result(text + fmt::format("would write {}\n", folder.string()));
    return 0;
  }
  const std::vector<StudyResult> results = run_cells(request, console);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw cannot_write(folder, error.value());
  const std::string text = study_text(results, axes), json = study_json(results, axes);
  write_file(folder / "study.txt", text);
  write_file(folder / "study.csv", study_csv(results));
  const auto names = range_names(results);
  for (std::size_t i = 0; i < names.size(); ++i)
    write_file(folder / fmt::format("study-{}.svg", dsp::slug(names[i])), study_figure(results, axes, i));
  write_file(folder / "study.json", json);
  console.result(console.json() ? json : fmt::format("{}\nresults are in {}\n", text, folder.string()));
  if (!kept_nothing(results)) return 0;
  console.error("fit.nothing_selected",
                "no setting selected a term. Give other candidates, or lower fit.tau or fit.threshold.");
  return 4;
}

}  // namespace apps
