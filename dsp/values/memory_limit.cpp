#include "dsp/values/memory_limit.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "dsp/values/fault.hpp"

namespace dsp {

void require_memory(const std::string& name, double bytes, std::size_t max_memory_bytes) {
  if (bytes <= static_cast<double>(max_memory_bytes)) return;
  throw Fault(
      FaultKind::numerics, "memory.limit",
      fmt::format("{}: needs {:.4g} MB of memory, {:.4g} MB are allowed. Try fewer channels, a shorter interval, "
                  "a lower prepare.rate_hz or a larger --max-memory",
                  name, 1e-6 * bytes, 1e-6 * static_cast<double>(max_memory_bytes)));
}

void require_machine_memory(std::string_view what, double bytes, std::string_view remedy) {
  const double memory = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  if (bytes > memory)
    throw Fault(FaultKind::numerics, "memory.exhausted",
                fmt::format("{} needs {:.3g} MB of memory, the machine has {:.3g} MB. {}", what, 1e-6 * bytes,
                            1e-6 * memory, remedy));
}

int threads_within_memory(double bytes_of_each, int num_threads, double most_bytes) {
  constexpr double most_threads = 1000.0;
  return std::max(1, std::min(num_threads,
                              1 + static_cast<int>(std::min(most_bytes / std::max(bytes_of_each, 1.0), most_threads))));
}

}  // namespace dsp
