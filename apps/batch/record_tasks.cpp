#include "apps/batch/record_tasks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <system_error>

#include "apps/config/recording_name.hpp"
#include "apps/process/path.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace apps {
namespace fs = std::filesystem;

std::vector<RecordTask> record_tasks(const std::vector<fs::path>& recordings) {
  const std::vector<std::string> names = recording_names(recordings);
  std::vector<RecordTask> tasks;
  std::map<fs::path, fs::path> seen;
  std::map<std::string, int> of_stem, of_name;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const fs::path& recording = recordings[i];
    const auto [first, is_new] = seen.emplace(resolved_path(recording), recording);
    if (!is_new)
      throw dsp::Fault(
          dsp::FaultKind::usage, "batch.twice",
          fmt::format("{} is given twice{}. Leave it out once", recording.string(),
                      first->second == recording ? "" : fmt::format(", also as {}", first->second.string())));
    std::error_code unknown;
    const std::uintmax_t bytes = fs::file_size(recording, unknown);
    tasks.push_back({recording, names[i], dsp::slug(first->first.stem().string()), unknown ? 0 : bytes});
    ++of_stem[tasks.back().name];
  }
  for (RecordTask& task : tasks) {
    if (of_stem[task.name] > 1) {
      std::string name = task.called;
      std::replace(name.begin(), name.end(), '/', '-');
      task.name = dsp::slug(name);
    }
    while (of_name[task.name]++ > 0) task.name += fmt::format("-{}", of_name[task.name]);  // what a name cannot hold
  }
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
