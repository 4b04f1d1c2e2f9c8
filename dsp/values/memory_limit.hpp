#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace dsp {

/// Throws Fault memory.limit (numerics) where `bytes` of memory, as estimated before any is taken, are more than
/// allowed. `name`: of the file or recording, for the message.
void require_memory(const std::string& name, double bytes, std::size_t max_memory_bytes);

/// Throws Fault memory.exhausted (numerics) where `bytes` are more than the machine has. `what` begins the message and
/// `remedy` ends it.
void require_machine_memory(std::string_view what, double bytes, std::string_view remedy);

/// How many of so many threads may be at work at a time where each takes these bytes, so that memory does not grow by
/// more than `most_bytes` for the second and those after it; at least 1.
[[nodiscard]] int threads_within_memory(double bytes_of_each, int num_threads, double most_bytes = 48e6);

}  // namespace dsp
