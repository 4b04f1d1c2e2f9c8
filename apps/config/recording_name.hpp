#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/config/config.hpp"

// What recordings are called in all outputs, and in what a person hands back: the name of the file; of several with one
// name the shortest ends of their paths that tell them apart, "mon/drive.csv". Folders are those that links lead to, so
// that neither the folder a command is typed in nor how a path is typed changes a name.

namespace apps {

/// Of these files, in their order. A file that is listed again is "drive.csv (2)". `runs`: which of several side by
/// side in each, "drive.csv run 2"; 0: it is one.
[[nodiscard]] std::vector<std::string> recording_names(const std::vector<std::filesystem::path>& files,
                                                       const std::vector<int>& runs = {});

/// Fills in the names of a config's recordings, fitted or for testing.
void name_recordings(Config& config);

/// Of a recording that a config does not list, beside those that it does; its name there, where it does list it.
[[nodiscard]] std::string name_beside(const std::filesystem::path& file, const Config& config);

/// Indices of the recordings that a person or a file calls so: the one of this name; else all whose paths end so, with
/// or without the extension.
[[nodiscard]] std::vector<std::size_t> recordings_called(const std::string& name,
                                                         const std::vector<RecordingConfig>& recordings);

}  // namespace apps
