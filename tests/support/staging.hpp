#pragma once
#include <filesystem>
#include <string>
#include <system_error>

namespace support {

/// The hidden folder beside `place` in which a command writes; where there is none, a path that leads nowhere.
inline std::filesystem::path staging_of(const std::filesystem::path& place) {
  const std::string begin = "." + place.filename().string() + ".ardent-";
  std::error_code unknown;  // folders come and go meanwhile
  for (const auto& entry : std::filesystem::directory_iterator(place.parent_path(), unknown))
    if (entry.path().filename().string().starts_with(begin)) return entry.path();
  return place.parent_path() / "no-staging-folder";
}

}  // namespace support
