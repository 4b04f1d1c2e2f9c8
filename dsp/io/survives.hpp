#pragma once
#include <functional>

namespace dsp {

/// Whether a process lives through it: tried in a child, which ends behind it whatever it throws, and within a minute
/// of processor time. For libraries that some damaged files bring down. Without a child to be had, true.
[[nodiscard]] bool survives(const std::function<void()>& action);

}  // namespace dsp
