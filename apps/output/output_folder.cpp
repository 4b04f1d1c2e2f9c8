#include "apps/output/output_folder.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "apps/output/earlier_result.hpp"
#include "apps/process/path.hpp"
#include "apps/process/system_fault.hpp"
#include "dsp/values/for_each_index.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

/// `destination`, if it is neither the current folder nor holds it.
const fs::path& not_around_us(const fs::path& destination) {
  require_not_current(destination);
  return destination;
}

fs::path plain(std::string_view name) {
  if (is_plain(name)) return name;
  throw std::invalid_argument(fmt::format("OutputFolder: a file name must be plain, got '{}'", name));
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
      staging_(
          destination_, [this](const Folder& folder, const std::string& name) { require_replaceable(folder, name); },
          num_threads) {
  const std::string name = destination_.filename();
  staging_.require_free(name);
  if (::mkdirat(staging_.fresh().descriptor(), name.c_str(), 0777) != 0) throw cannot_write(destination_, errno);
  folder_ = staging_.fresh().open(name);
  // Who may look into the folder stays as it was.
  const std::optional<FolderEntry> before = staging_.parent().entry(name);
  if (before && ::fchmod(folder_.descriptor(), before->stx_mode & 07777) != 0) throw cannot_write(destination_, errno);
}

/// Absent, empty or an earlier result with nothing else in it.
void OutputFolder::require_replaceable(const Folder& folder, const std::string& name) const {
  const auto refuse = [&](std::string_view why) {
    throw output_fault("output.foreign", destination_,
                       fmt::format("{}, so it is not replaced. Choose another place with -o", why));
  };
  const std::optional<FolderEntry> entry = folder.entry(name);
  if (!entry || !entry->is_folder()) refuse("exists and is not a folder");
  const Folder there = folder.open(name);
  if (there.names().empty()) return;
  const std::optional<EarlierResult> earlier = earlier_result(there, num_threads_);
  if (!earlier) refuse("holds files but no manifest.json of Ardent's");
  const std::vector<fs::path>& foreign = earlier->foreign;
  const bool several = foreign.size() > 1;
  if (!foreign.empty())
    throw output_fault(
        "output.foreign", destination_ / foreign.front(),
        fmt::format("{}{} not as Ardent wrote the folder (added or changed since), so nothing is replaced. Move {} "
                    "elsewhere or choose another place with -o",
                    several ? fmt::format("and {} more", foreign.size() - 1) : "is", several ? " are" : "",
                    several ? "them" : "it"));
  if (!force_)
    throw output_fault("output.exists", destination_,
                       "holds earlier results. Use --force to replace them or -o to write elsewhere");
}

fs::path OutputFolder::path(std::string_view name) const {
  return folder_.path() / plain(name);
}

void OutputFolder::make_folder(std::string_view name) const {
  Folder folder = folder_;
  for (const fs::path& part : fs::path(name)) {
    if (::mkdirat(folder.descriptor(), part.c_str(), 0777) != 0 && errno != EEXIST)
      throw cannot_write(shown(name), errno);
    folder = folder.open(part);
  }
}

OutputFile OutputFolder::file(std::string_view name) const {
  const fs::path file = plain(name);
  make_folder(file.parent_path().string());
  return {folder_, file, shown(name)};
}

void OutputFolder::write(std::string_view name, std::string_view bytes) const {
  OutputFile opened = file(name);
  opened.write(bytes);
  opened.close();
}

void OutputFolder::commit(Manifest manifest) {
  std::vector<NamedEntry> files = folder_.tree();
  std::erase_if(files, [](const NamedEntry& one) { return one.second.is_folder(); });
  manifest.outputs.assign(files.size(), {});
  dsp::for_each_index(files.size(), num_threads_, [&](std::size_t i) {
    const fs::path& name = files[i].first;
    manifest.outputs[i] = {name.generic_string(), sha256_written(folder_, name, destination_ / name)};
  });
  std::sort(manifest.outputs.begin(), manifest.outputs.end(),
            [](const ManifestFile& a, const ManifestFile& b) { return a.path < b.path; });
  manifest.finished_utc = utc_now();
  write(manifest_name, manifest_json(manifest));
  staging_.place({destination_.filename()});
}

}  // namespace apps
