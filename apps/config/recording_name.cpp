#include "apps/config/recording_name.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>

#include "apps/process/path.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

std::vector<fs::path> files_of(const Config& config) {
  std::vector<fs::path> files;
  for (const auto* recordings : {&config.recordings, &config.test_recordings})
    for (const RecordingConfig& recording : *recordings) files.push_back(recording.file);
  return files;
}

/// Whether the last parts of `path` are those of `end`.
bool ends_in(const fs::path& path, const fs::path& end) {
  const auto parts = std::distance(path.begin(), path.end()), wanted = std::distance(end.begin(), end.end());
  return wanted > 0 && wanted <= parts && std::equal(end.begin(), end.end(), std::next(path.begin(), parts - wanted));
}

}  // namespace

std::vector<std::string> recording_names(const std::vector<fs::path>& files, const std::vector<int>& runs) {
  std::vector<fs::path> located;
  for (const fs::path& file : files) located.push_back(located_path(file));
  std::vector<std::string> names = distinct_names(located);
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (runs[i] > 0) names[i] += fmt::format(" run {}", runs[i]);
  std::map<std::string, int> count;
  for (std::string& name : names)
    if (const int number = ++count[name]; number > 1) name += fmt::format(" ({})", number);
  return names;
}

void name_recordings(Config& config) {
  std::vector<int> runs;
  for (const auto* recordings : {&config.recordings, &config.test_recordings})
    for (const RecordingConfig& recording : *recordings) runs.push_back(recording.run);
  std::vector<std::string> names = recording_names(files_of(config), runs);
  auto next = names.begin();
  for (auto* recordings : {&config.recordings, &config.test_recordings})
    for (RecordingConfig& recording : *recordings) recording.name = std::move(*next++);
}

std::string name_beside(const fs::path& file, const Config& config) {
  for (const auto* recordings : {&config.recordings, &config.test_recordings})
    for (const RecordingConfig& recording : *recordings)
      if (located_path(recording.file) == located_path(file)) return recording.name;
  std::vector<fs::path> files = files_of(config);
  files.push_back(file);
  return recording_names(files).back();
}

std::vector<std::size_t> recordings_called(const std::string& name, const std::vector<RecordingConfig>& recordings) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    if (recordings[i].name == name) return {i};
    const fs::path path = located_path(recordings[i].file);
    if (ends_in(path, name) || ends_in(path.parent_path() / path.stem(), name)) found.push_back(i);
  }
  return found;
}

}  // namespace apps
