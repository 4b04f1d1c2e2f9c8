#pragma once
#include <filesystem>
#include <vector>

#include "apps/process/console.hpp"

namespace apps {

/// `ardent info FILE...`: container, channels, rate, length, sidecar of each recording, from its header.
/// Throws dsp::Fault for the first file that is none, and where `strict` for warnings.
void run_info(const std::vector<std::filesystem::path>& files, bool salvage, bool strict, Console& console);

}  // namespace apps
