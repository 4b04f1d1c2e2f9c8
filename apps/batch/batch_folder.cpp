#include "apps/batch/batch_folder.hpp"

#include <fmt/format.h>
#include <stdio.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <system_error>

#include "apps/process/earlier_result.hpp"
#include "apps/process/output_file.hpp"
#include "apps/process/output_folder.hpp"
#include "apps/process/path.hpp"
#include "apps/process/sha256.hpp"
#include "apps/process/system_fault.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

fs::path place_of(const fs::path& destination) {
  require_not_current(destination);
  return named_path(destination);
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw cannot_write(folder, error.value());
}

}  // namespace

BatchFolder::BatchFolder(const fs::path& destination) : destination_(place_of(destination)), staging_(destination_) {
  require_no_link(destination_);
  std::error_code unknown;
  const bool is_folder = fs::is_directory(fs::symlink_status(destination_, unknown));
  if (!is_folder && fs::exists(fs::symlink_status(destination_, unknown)))
    throw output_fault("output.foreign", destination_, "is there and is no folder. Choose another place with -o");
  require_no_link(runs());
  if (is_folder && !entries_of(destination_).empty()) remove_summary();
  make_folder(runs());
  make_folder(staging_.fresh(destination_));
}

void BatchFolder::remove_summary() const {
  const std::optional<Manifest> manifest = read_manifest(destination_);
  std::error_code unknown;
  const bool is_batch = manifest ? manifest->command == "batch" : fs::is_directory(runs(), unknown);
  if (!is_batch)
    throw output_fault("output.foreign", destination_,
                       "holds files that no batch has written, so nothing is put there. Choose another place with -o");
  if (!manifest) return;
  for (const ManifestFile& file : manifest->outputs) {
    const fs::path path = destination_ / file.path;
    if (fs::exists(fs::symlink_status(path, unknown)) && sha256_written(path, path) != file.sha256)
      throw output_fault("output.foreign", path,
                         "was changed since the batch wrote it and would be replaced. Move it elsewhere");
  }
  // The manifest last: where it is, what else there is of the summary is known by it.
  for (const ManifestFile& file : manifest->outputs) remove_tree(destination_ / file.path);
  remove_tree(destination_ / manifest_name);
}

void BatchFolder::write(const std::string& name, std::string_view bytes) {
  write_file(staging_.fresh(destination_) / name, destination_ / name, bytes);
  written_.push_back({name, sha256(bytes)});
}

void BatchFolder::commit(Manifest manifest) {
  manifest.outputs = written_;
  std::sort(manifest.outputs.begin(), manifest.outputs.end(),
            [](const ManifestFile& a, const ManifestFile& b) { return a.path < b.path; });
  manifest.finished_utc = utc_now();
  write(manifest_name, manifest_json(manifest));
  for (const ManifestFile& file : written_) {
    const fs::path place = destination_ / file.path;
    if (::rename((staging_.fresh(destination_) / file.path).c_str(), place.c_str()) != 0)
      throw cannot_write(place, errno);
    if (&file + 1 == &written_.back()) sync_entry(destination_, destination_);  // before the manifest
  }
  sync_entry(destination_, destination_);
}

}  // namespace apps
