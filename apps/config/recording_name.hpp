#pragma once
#include <filesystem>
#include <string>

#include "apps/config/config.hpp"

namespace apps {

/// What a recording of a config is called in all outputs: its file's name; of several with one name, with the folders
/// that tell them apart, "mon/drive.csv".
[[nodiscard]] std::string recording_name(const std::filesystem::path& file, const Config& config);

}  // namespace apps
