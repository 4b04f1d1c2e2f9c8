#include "apps/output/earlier_result.hpp"

#include <fcntl.h>

#include <algorithm>
#include <map>
#include <set>

#include "apps/process/sha256.hpp"
#include "apps/process/system_fault.hpp"
#include "dsp/values/for_each_index.hpp"

namespace apps {
namespace fs = std::filesystem;

std::string sha256_written(const Folder& folder, const fs::path& file, const fs::path& shown) {
  const Descriptor opened(folder.open_file(file, O_RDONLY));
  try {
    return sha256_file(opened.path());
  } catch (const dsp::Fault&) {
    throw output_fault("output.write", shown, "cannot be read again. Check the disk");
  }
}

EarlierResult earlier_result(const Folder& folder, const std::vector<ManifestFile>& listed, int num_threads) {
  std::map<fs::path, std::string> hashes;
  std::set<fs::path> folders;
  for (const ManifestFile& file : listed) {
    hashes[file.path] = file.sha256;
    for (fs::path parent = fs::path(file.path).parent_path(); !parent.empty(); parent = parent.parent_path())
      folders.insert(parent);
  }
  const std::vector<NamedEntry> found = folder.tree([&](const fs::path& name) { return folders.contains(name); });
  std::vector<char> is_own(found.size(), 0);
  dsp::for_each_index(found.size(), num_threads, [&](std::size_t i) {
    const auto& [name, entry] = found[i];
    const auto hash = hashes.find(name);
    is_own[i] = (entry.is_folder() && folders.contains(name)) || (entry.is_file() && name == manifest_name) ||
                (entry.is_file() && hash != hashes.end() &&
                 sha256_written(folder, name, folder.shown() / name) == hash->second);
  });
  EarlierResult result;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (is_own[i] != 0)
      result.own.push_back(found[i]);
    else
      result.foreign.push_back(found[i].first);
  std::stable_partition(result.own.begin(), result.own.end(),
                        [](const NamedEntry& one) { return one.first != manifest_name; });
  std::sort(result.foreign.begin(), result.foreign.end());
  return result;
}

std::optional<EarlierResult> earlier_result(const Folder& folder, int num_threads) {
  const auto listed = listed_outputs(folder.path());
  if (!listed) return std::nullopt;
  return earlier_result(folder, *listed, num_threads);
}

}  // namespace apps
