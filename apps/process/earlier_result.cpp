#include "apps/process/earlier_result.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <system_error>

#include "apps/process/path.hpp"
#include "apps/process/sha256.hpp"
#include "apps/process/system_fault.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

/// The folders between a folder of results and its files; a parent comes before what is in it.
std::set<fs::path> folders_of(const std::vector<ManifestFile>& listed) {
  std::set<fs::path> folders;
  for (const ManifestFile& file : listed)
    for (fs::path parent = fs::path(file.path).parent_path(); !parent.empty(); parent = parent.parent_path())
      folders.insert(parent);
  return folders;
}

}  // namespace

std::string sha256_written(const fs::path& file, const fs::path& shown) {
  try {
    return sha256_file(file);
  } catch (const dsp::Fault&) {
    throw output_fault("output.write", shown, "cannot be read again. Check the disk");
  }
}

std::vector<fs::path> foreign_entries(const fs::path& folder, const std::vector<ManifestFile>& listed) {
  std::map<fs::path, std::string> hashes;
  for (const ManifestFile& file : listed) hashes[file.path] = file.sha256;
  const std::set<fs::path> folders = folders_of(listed);
  const auto is_ours = [&](const fs::path& name, const fs::file_status& status) {
    if (fs::is_directory(status)) return folders.contains(name);
    if (!fs::is_regular_file(status)) return false;
    const auto hash = hashes.find(name);
    return hash == hashes.end() ? name == manifest_name : sha256_written(folder / name, folder / name) == hash->second;
  };
  std::vector<fs::path> foreign, open{folder};
  while (!open.empty()) {
    const fs::path next = open.back();
    open.pop_back();
    for (const fs::path& entry : entries_of(next)) {
      std::error_code unknown;
      const fs::path name = entry.lexically_relative(folder);
      const fs::file_status status = fs::symlink_status(entry, unknown);
      if (!is_ours(name, status))
        foreign.push_back(name);
      else if (fs::is_directory(status))
        open.push_back(entry);
    }
  }
  std::sort(foreign.begin(), foreign.end());
  return foreign;
}

bool remove_result(const fs::path& folder, const std::vector<ManifestFile>& listed) {
  std::error_code ignored;  // what cannot be removed is seen at the end
  for (const ManifestFile& file : listed) fs::remove(folder / file.path, ignored);
  const std::set<fs::path> folders = folders_of(listed);
  std::for_each(folders.rbegin(), folders.rend(), [&](const fs::path& name) { fs::remove(folder / name, ignored); });
  if (entries_of(folder).size() == 1) fs::remove(folder / manifest_name, ignored);
  return fs::remove(folder, ignored);
}

}  // namespace apps
