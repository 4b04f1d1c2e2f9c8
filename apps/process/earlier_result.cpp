#include "apps/process/earlier_result.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <system_error>

#include "apps/process/path.hpp"
#include "apps/process/sha256.hpp"
#include "apps/process/system_fault.hpp"
#include "dsp/for_each_index.hpp"

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

std::vector<fs::path> foreign_entries(const fs::path& folder, const std::vector<ManifestFile>& listed,
                                      int num_threads) {
  std::map<fs::path, std::string> hashes;
  for (const ManifestFile& file : listed) hashes[file.path] = file.sha256;
  const std::set<fs::path> folders = folders_of(listed);
  std::vector<fs::path> foreign, known, open{folder};
  while (!open.empty()) {
    const fs::path next = open.back();
    open.pop_back();
    for (const fs::path& entry : entries_of(next)) {
      std::error_code unknown;
      const fs::path name = entry.lexically_relative(folder);
      const fs::file_status status = fs::symlink_status(entry, unknown);
      const bool is_file = fs::is_regular_file(status);
      if (fs::is_directory(status) && folders.contains(name))
        open.push_back(entry);
      else if (is_file && hashes.contains(name))
        known.push_back(name);
      else if (!is_file || name != manifest_name)
        foreign.push_back(name);
    }
  }
  std::vector<char> changed(known.size(), 0);
  dsp::for_each_index(known.size(), num_threads, [&](std::size_t i) {
    const fs::path file = folder / known[i];
    changed[i] = sha256_written(file, file) == hashes.at(known[i]) ? 0 : 1;
  });
  for (std::size_t i = 0; i < known.size(); ++i)
    if (changed[i] != 0) foreign.push_back(known[i]);
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
