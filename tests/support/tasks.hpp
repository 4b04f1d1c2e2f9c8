#pragma once
#include <cstddef>
#include <filesystem>
#include <iterator>

namespace support {

/// Threads this process has.
inline std::ptrdiff_t num_tasks() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return std::distance(begin(tasks), end(tasks));
}

}  // namespace support
