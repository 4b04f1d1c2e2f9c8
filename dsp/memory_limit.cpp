#include "dsp/memory_limit.hpp"

#include <fmt/format.h>

#include "dsp/fault.hpp"

namespace dsp {

void require_memory(const std::string& name, double bytes, std::size_t max_memory_bytes) {
  if (bytes <= static_cast<double>(max_memory_bytes)) return;
  throw Fault(
      FaultKind::numerics, "memory.limit",
      fmt::format("{}: needs {:.4g} MB of memory, {:.4g} MB are allowed. Try fewer channels, a shorter interval, "
                  "a lower prepare.rate_hz or a larger --max-memory",
                  name, 1e-6 * bytes, 1e-6 * static_cast<double>(max_memory_bytes)));
}

}  // namespace dsp
