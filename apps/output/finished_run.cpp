#include "apps/output/finished_run.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <system_error>

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

}  // namespace apps
