#include "apps/output/finished_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "apps/output/run_json.hpp"
#include "apps/process/sha256.hpp"

namespace apps {
namespace fs = std::filesystem;

void check_finished_run(const fs::path& run, bool strict, Console& console) {
  std::error_code error;
  if (!fs::is_directory(run, error)) {
    const bool there = fs::exists(fs::symlink_status(run, error));
    throw dsp::Fault(dsp::FaultKind::input, "run.incomplete",
                     fmt::format("{}: {}, want the folder of a finished run", run.string(),
                                 there ? "is no folder" : "is not there"));
  }
  static_cast<void>(read_run_json(run / manifest_name));
  const auto listed = listed_outputs(run);
  if (!listed)
    console.warning(
        "run.changed",
        fmt::format("{}: is not as Ardent writes it, so changes of the run's files cannot be detected. Run it again",
                    (run / manifest_name).string()));
  for (const ManifestFile& file : listed.value_or(std::vector<ManifestFile>())) {
    const fs::path path = run / file.path;
    std::error_code unknown;
    const bool there = fs::is_regular_file(path, unknown);
    if (!there || sha256_file(path) != file.sha256)
      console.warning("run.changed",
                      fmt::format("{}: {} since the run was written. If that was not intended, run it again",
                                  path.string(), there ? "has changed" : "is missing"));
  }
  refuse_warnings(strict, console);
}

std::string fitted_name(const Manifest& run, const Config& config, const std::string& sha256) {
  const auto has_name = [](const ManifestFile& input) { return !input.recording.empty(); };
  if (std::none_of(run.inputs.begin(), run.inputs.end(), has_name)) {
    // Of a program that did not write names: recordings are among the inputs in the order of the config.
    auto next = run.inputs.begin();
    for (const RecordingConfig& fitted : config.recordings) {
      const fs::path file = fitted.file.filename();
      next = std::find_if(next, run.inputs.end(),
                          [&](const ManifestFile& input) { return fs::path(input.path).filename() == file; });
      if (next == run.inputs.end()) break;
      if (next++->sha256 == sha256) return fitted.name;
    }
    return "";
  }
  std::size_t left = config.recordings.size();  // those for testing are behind them
  for (const ManifestFile& input : run.inputs) {
    if (input.recording.empty()) continue;
    if (left-- == 0) break;
    if (input.sha256 == sha256) return input.recording;
  }
  return "";
}

void take_names(const Manifest& run, Config& config) {
  std::vector<std::string> names;
  for (const ManifestFile& input : run.inputs)
    if (!input.recording.empty()) names.push_back(input.recording);
  if (names.size() != config.recordings.size() + config.test_recordings.size()) return;
  auto next = names.begin();
  for (auto* recordings : {&config.recordings, &config.test_recordings})
    for (RecordingConfig& recording : *recordings) recording.name = std::move(*next++);
}

}  // namespace apps
