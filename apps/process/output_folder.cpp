#include "apps/process/output_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <system_error>

#include "apps/process/earlier_result.hpp"
#include "apps/process/path.hpp"
#include "apps/process/system_fault.hpp"
#include "dsp/for_each_index.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

/// `destination`, if it is neither the current folder nor holds it.
const fs::path& not_around_us(const fs::path& destination) {
  require_not_current(destination);
  return destination;
}

/// Whether an earlier result of ours is at `destination`, which is not free otherwise: foreign.
bool holds_result(const fs::path& destination, int num_threads) {
  constexpr std::string_view advice = "so it is not replaced. Choose another place with -o";
  std::error_code error;
  const auto status = fs::symlink_status(destination, error);
  if (!fs::exists(status)) return false;
  if (!fs::is_directory(status))
    throw output_fault("output.foreign", destination, fmt::format("exists and is not a folder, {}", advice));
  if (entries_of(destination).empty()) return false;
  const auto listed = listed_outputs(destination);
  if (!listed)
    throw output_fault("output.foreign", destination,
                       fmt::format("holds files but no manifest.json of Ardent's, {}", advice));
  const std::vector<fs::path> foreign = foreign_entries(destination, *listed, num_threads);
  if (foreign.empty()) return true;
  const bool several = foreign.size() > 1;
  throw output_fault(
      "output.foreign", destination / foreign.front(),
      fmt::format("{}{} not as Ardent wrote the folder (added or changed since), so nothing is replaced. Move {} "
                  "elsewhere or choose another place with -o",
                  several ? fmt::format("and {} more", foreign.size() - 1) : "is", several ? " are" : "",
                  several ? "them" : "it"));
}

}  // namespace

void require_apart(const fs::path& destination, const std::vector<fs::path>& inputs) {
  const fs::path output = resolved_path(destination);
  for (const fs::path& input : inputs) {
    const fs::path source = resolved_path(input);
    if (lies_in(output, source) || lies_in(source, output))
      throw dsp::Fault(
          dsp::FaultKind::usage, "output.overlap",
          fmt::format("{}: the output {} the input {}. Choose another place with -o.", destination.string(),
                      output == source          ? "is"
                      : lies_in(output, source) ? "lies inside"
                                                : "would hold",
                      input.string()));
  }
}

void require_not_current(const fs::path& destination) {
  std::error_code unknown;
  const fs::path here = fs::current_path(unknown);
  if (!unknown && lies_in(resolved_path(here), resolved_path(destination)))
    throw dsp::Fault(dsp::FaultKind::usage, "output.current",
                     fmt::format("{}: is the current folder or holds it; results come as a folder of their own. Name a "
                                 "new one in it, as in -o results",
                                 destination.string()));
}

OutputFolder::OutputFolder(const fs::path& destination, bool force, int num_threads)
    : destination_(named_path(not_around_us(destination))),
      force_(force),
      num_threads_(num_threads),
      staging_(destination_) {
  require_free();
  const fs::path fresh = staging_.fresh(destination_);
  make_folder(fresh);
  // Who may look into the folder stays as it was.
  std::error_code absent, error;
  const fs::file_status before = fs::status(destination_, absent);
  if (!absent && fs::is_directory(before)) fs::permissions(fresh, before.permissions(), error);
  if (error) throw cannot_write(destination_, error.value());
}

void OutputFolder::require_free() const {
  require_no_link(destination_);
  if (holds_result(destination_, num_threads_) && !force_)
    throw output_fault("output.exists", destination_,
                       "holds earlier results. Use --force to replace them or -o to write elsewhere");
}

void OutputFolder::make_folder(const fs::path& folder) const {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw cannot_write(destination_, error.value());
}

fs::path OutputFolder::path(std::string_view name) const {
  if (!is_plain(name))
    throw std::invalid_argument(fmt::format("OutputFolder: a file name must be plain, got '{}'", name));
  return staging_.fresh(destination_) / name;
}

OutputFile OutputFolder::file(std::string_view name) const {
  make_folder(path(name).parent_path());
  return {path(name), shown(name), OnDisk::later};
}

void OutputFolder::write(std::string_view name, std::string_view bytes) const {
  make_folder(path(name).parent_path());
  write_file(path(name), shown(name), bytes, OnDisk::later);
}

void OutputFolder::commit(Manifest manifest) {
  const fs::path written = staging_.fresh(destination_);
  std::vector<fs::path> folders{written};
  std::vector<fs::path> files;
  for (std::size_t i = 0; i < folders.size(); ++i)
    for (const fs::path& entry : entries_of(fs::path(folders[i]))) {
      std::error_code unknown;
      (fs::is_directory(fs::symlink_status(entry, unknown)) ? folders : files).push_back(entry);
    }
  manifest.outputs.assign(files.size(), {});
  dsp::for_each_index(files.size(), num_threads_, [&](std::size_t i) {
    const std::string name = files[i].lexically_relative(written).generic_string();
    manifest.outputs[i] = {name, sha256_written(files[i], shown(name))};
    sync_entry(files[i], shown(name));
  });
  std::sort(manifest.outputs.begin(), manifest.outputs.end(),
            [](const ManifestFile& a, const ManifestFile& b) { return a.path < b.path; });
  manifest.finished_utc = utc_now();
  write(manifest_name, manifest_json(manifest));
  sync_entry(path(manifest_name), shown(manifest_name));
  for (const fs::path& folder : folders) sync_entry(folder, destination_);
  require_free();  // a person may have come meanwhile
  staging_.place({destination_}, force_);
}

}  // namespace apps
