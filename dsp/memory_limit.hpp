#pragma once
#include <cstddef>
#include <string>

namespace dsp {

/// Throws Fault memory.limit (numerics) where `bytes` of memory, as estimated before any is taken, are more than
/// allowed. `name`: of the file or recording, for the message.
void require_memory(const std::string& name, double bytes, std::size_t max_memory_bytes);

}  // namespace dsp
