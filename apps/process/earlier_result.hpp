#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "apps/output/manifest.hpp"

namespace apps {

/// SHA-256 of a file that was written earlier. Throws dsp::Fault (output, "output.write") that calls it `shown`.
[[nodiscard]] std::string sha256_written(const std::filesystem::path& file, const std::filesystem::path& shown);

/// What lies in `folder` and is not as its manifest lists it: further files and folders, links, listed files whose
/// bytes have changed; up to num_threads threads look at these. Relative paths, sorted. Listed files may be missing.
/// Throws dsp::Fault (output, "output.write").
[[nodiscard]] std::vector<std::filesystem::path> foreign_entries(const std::filesystem::path& folder,
                                                                 const std::vector<ManifestFile>& listed,
                                                                 int num_threads = 1);

/// Removes a folder of results: the files its manifest lists, folders that are then empty, the manifest at last. False
/// if anything else was in it, which stays.
[[nodiscard]] bool remove_result(const std::filesystem::path& folder, const std::vector<ManifestFile>& listed);

}  // namespace apps
