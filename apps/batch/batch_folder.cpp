#include "apps/batch/batch_folder.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <system_error>

#include "apps/output/earlier_result.hpp"
#include "apps/output/output_folder.hpp"
#include "apps/process/output_file.hpp"
#include "apps/process/path.hpp"
#include "apps/process/sha256.hpp"
#include "apps/process/system_fault.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

/// A folder or nothing: everything else is refused.
bool is_folder(const fs::path& place) {
  std::error_code unknown;
  const fs::file_status status = fs::symlink_status(place, unknown);
  if (fs::is_symlink(status)) throw link_at(place);
  if (fs::exists(status) && !fs::is_directory(status))
    throw output_fault("output.foreign", place, "is there and is no folder. Choose another place with -o");
  return fs::is_directory(status);
}

/// Absent, empty or of a batch.
fs::path place_of(const fs::path& destination) {
  require_not_current(destination);
  fs::path place = named_path(destination);
  const bool has_runs = is_folder(place / BatchFolder::runs_name);
  if (!is_folder(place) || Folder(place, place).names().empty()) return place;
  const std::optional<Manifest> manifest = read_manifest(place);
  if (manifest ? manifest->command != "batch" : !has_runs)
    throw output_fault("output.foreign", place,
                       "holds files that no batch has written, so nothing is put there. Choose another place with -o");
  return place;
}

}  // namespace

BatchFolder::BatchFolder(const fs::path& destination)
    : destination_(place_of(destination)), staging_(destination_ / "summary") {
  remove_summary();
  for (const char* name : summary_names) staging_.require_free(name);
  if (::mkdirat(staging_.parent().descriptor(), runs_name, 0777) != 0 && errno != EEXIST)
    throw cannot_write(runs(), errno);
}

/// Its manifest last: where it is, what else there is of the summary is known by it.
void BatchFolder::remove_summary() const {
  const Folder& folder = staging_.parent();
  const auto listed = listed_outputs(folder.path());
  if (!listed) return;
  const EarlierResult earlier = earlier_result(folder, *listed);
  for (const ManifestFile& file : *listed)
    if (std::binary_search(earlier.foreign.begin(), earlier.foreign.end(), fs::path(file.path)))
      throw output_fault("output.foreign", destination_ / file.path,
                         "was changed since the batch wrote it and would be replaced. Move it elsewhere");
  folder.remove(earlier.own);
}

void BatchFolder::write(const std::string& name, std::string_view bytes) {
  write_file(staging_.fresh(), name, destination_ / name, bytes);
  written_.push_back({name, sha256(bytes)});
}

void BatchFolder::commit(Manifest manifest) {
  manifest.outputs = written_;
  std::sort(manifest.outputs.begin(), manifest.outputs.end(),
            [](const ManifestFile& a, const ManifestFile& b) { return a.path < b.path; });
  manifest.finished_utc = utc_now();
  write(manifest_name, manifest_json(manifest));
  std::vector<std::string> names;
  for (const ManifestFile& file : written_) names.push_back(file.path);
  staging_.place(names);
}

}  // namespace apps
