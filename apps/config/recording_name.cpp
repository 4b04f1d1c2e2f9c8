#include "apps/config/recording_name.hpp"

#include <algorithm>
#include <vector>

#include "apps/output/run_changes.hpp"

namespace apps {
namespace fs = std::filesystem;

std::string recording_name(const fs::path& file, const Config& config) {
  const auto same_name = [&](const RecordingConfig& other) { return other.file.filename() == file.filename(); };
  std::vector<fs::path> files;
  for (const RecordingConfig& recording : config.recordings)
    if (same_name(recording)) files.push_back(recording.file);
  const auto own = std::find(files.begin(), files.end(), file);
  return own == files.end() ? file.filename().string()
                            : distinct_names(files)[static_cast<std::size_t>(own - files.begin())];
}

}  // namespace apps
