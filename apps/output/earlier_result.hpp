#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/output/manifest.hpp"
#include "apps/process/folder.hpp"

namespace apps {

/// What lies in a folder of results, held against its manifest.
struct EarlierResult {
  std::vector<NamedEntry>
      own;  ///< files as they are listed and their folders, in an order to remove them, manifest last
  std::vector<std::filesystem::path> foreign;  ///< all else: further entries, links, files with other bytes; sorted
};

/// Listed files may be missing; up to num_threads threads look at them. Throws dsp::Fault (output, "output.write").
[[nodiscard]] EarlierResult earlier_result(const Folder& folder, const std::vector<ManifestFile>& listed,
                                           int num_threads = 1);
/// By the manifest in the folder; nothing if it has none of Ardent's.
[[nodiscard]] std::optional<EarlierResult> earlier_result(const Folder& folder, int num_threads = 1);

/// SHA-256 of a file that was written earlier, by its path in the folder. Throws dsp::Fault (output, "output.write")
/// that calls it `shown`.
[[nodiscard]] std::string sha256_written(const Folder& folder, const std::filesystem::path& file,
                                         const std::filesystem::path& shown);

}  // namespace apps
