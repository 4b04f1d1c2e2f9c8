#include "apps/process/background_hashes.hpp"

#include <system_error>
#include <utility>

#include "apps/process/sha256.hpp"

namespace apps {
namespace fs = std::filesystem;

HashesBeside::HashesBeside(const std::vector<fs::path>& files, int num_threads) {
  if (num_threads < 2) return;
  using Task = std::packaged_task<std::string(const std::stop_token&)>;
  std::vector<Task> tasks;
  for (const fs::path& file : files) {
    Task task([file](const std::stop_token& stop) { return sha256_file(file, stop); });
    if (hashes_.emplace(file, task.get_future().share()).second) tasks.push_back(std::move(task));
  }
  try {
    thread_ = std::jthread([tasks = std::move(tasks)](const std::stop_token& stop) mutable {
      for (Task& task : tasks) {
        if (stop.stop_requested()) return;
        task(stop);
      }
    });
  } catch (const std::system_error&) {  // no further thread to be had
    hashes_.clear();
  }
}

std::string HashesBeside::of(const fs::path& file) {
  const auto found = hashes_.find(file);
  return found == hashes_.end() ? sha256_file(file) : found->second.get();
}

}  // namespace apps
