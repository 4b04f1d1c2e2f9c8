#include "apps/batch/record_tasks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <system_error>

#include "apps/config/recording_name.hpp"
#include "apps/process/path.hpp"
#include "dsp/fault.hpp"
#include "dsp/names.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

/// The name of a recording with ever more of its path: stem, file name, folder and file name, ...
std::string name_of(const fs::path& resolved, int level) {
  if (level == 0) return dsp::slug(resolved.stem().string());
  std::string name = resolved.filename().string();
  fs::path folder = resolved.parent_path();
  for (int i = 1; i < level && folder.has_relative_path(); ++i, folder = folder.parent_path())
    name = folder.filename().string() + "-" + name;
  return dsp::slug(name);
}

}  // namespace

std::vector<RecordTask> record_tasks(const std::vector<fs::path>& recordings) {
  std::vector<RecordTask> tasks;
  std::vector<fs::path> resolved;
  std::map<fs::path, fs::path> seen;
  for (const fs::path& recording : recordings) {
    resolved.push_back(resolved_path(recording));
    if (const auto [first, is_new] = seen.emplace(resolved.back(), recording); !is_new)
      throw dsp::Fault(
          dsp::FaultKind::usage, "batch.twice",
          fmt::format("{} is given twice{}. Leave it out once", recording.string(),
                      first->second == recording ? "" : fmt::format(", also as {}", first->second.string())));
    std::error_code unknown;
    const std::uintmax_t bytes = fs::file_size(recording, unknown);
    tasks.push_back({recording, {}, name_of(resolved.back(), 0), unknown ? 0 : bytes});
  }
  const std::vector<std::string> names = recording_names(recordings);
  for (std::size_t i = 0; i < tasks.size(); ++i) tasks[i].called = names[i];
  constexpr int most_levels = 8;
  for (int level = 1; level <= most_levels; ++level) {
    std::map<std::string, int> count;
    for (const RecordTask& task : tasks) ++count[task.name];
    for (std::size_t i = 0; i < tasks.size(); ++i)
      if (count[tasks[i].name] > 1) tasks[i].name = name_of(resolved[i], level);
  }
  std::map<std::string, int> count;  // paths that differ in what a name cannot hold
  for (RecordTask& task : tasks)
    while (count[task.name]++ > 0) task.name += fmt::format("-{}", count[task.name]);
  return tasks;
}

std::vector<std::size_t> longest_first(const std::vector<RecordTask>& tasks) {
  std::vector<std::size_t> order(tasks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return tasks[a].bytes > tasks[b].bytes; });
  return order;
}

}  // namespace apps
