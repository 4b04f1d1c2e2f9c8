#include "apps/output/finished_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "apps/config/recording_name.hpp"
#include "apps/output/manifest.hpp"
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

std::string fitted_name(const fs::path& run, const Config& config, const fs::path& recording) {
  const std::string hash = sha256_file(recording);
  std::vector<ManifestFile> inputs = read_manifest(run).value_or(Manifest()).inputs;
  for (const RecordingConfig& fitted : config.recordings) {  // in the order of the manifest's inputs
    const auto found = std::find_if(inputs.begin(), inputs.end(), [&](const ManifestFile& input) {
      return input.path == manifest_path(fitted.file, run);
    });
    if (found == inputs.end()) continue;
    if (found->sha256 == hash) return recording_name(fitted.file, config);
    inputs.erase(found);  // the next of this name is another
  }
  return "";
}

}  // namespace apps
