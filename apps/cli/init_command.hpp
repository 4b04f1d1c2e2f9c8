#pragma once
#include <filesystem>

#include "apps/process/console.hpp"

namespace apps {

/// `ardent init FILE`: a first sidecar (NAME.ext.toml) and config (NAME.toml) beside the recording, or in `folder`;
/// what the file says is filled in, the rest commented out. A file that is there stays unless `force`: dsp::Fault
/// (output, "output.exists").
void run_init(const std::filesystem::path& recording, const std::filesystem::path& folder, bool force,
              Console& console);

}  // namespace apps
