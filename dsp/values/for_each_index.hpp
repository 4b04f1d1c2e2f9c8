#pragma once
#include <cstddef>
#include <functional>

namespace dsp {

/// Calls action(0) ... action(count - 1), on up to num_threads threads of which the caller's is one; on fewer where the
/// system gives no more. Which thread does what differs, so an action must not depend on the others. The first
/// exception by index among those thrown is rethrown here once all threads have ended; what has not begun by then is
/// left out.
void for_each_index(std::size_t count, int num_threads, const std::function<void(std::size_t)>& action);

}  // namespace dsp
