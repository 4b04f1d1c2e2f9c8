#pragma once
#include <functional>

#include "apps/process/console.hpp"

namespace apps {

/// Does `action` and returns its exit code. Whatever it throws is said on the console in one line and becomes 2
/// (command line or settings), 3 (input), 4 (numerics, memory), 5 (output), 128 + signal, or 1: a mistake of ours.
/// Throws nothing, also where there is no memory for the message.
[[nodiscard]] int ending_of(const std::function<int()>& action, Console& console) noexcept;

/// Says that there is no memory left, and ends the program: where nobody would catch it.
[[noreturn]] void end_without_memory() noexcept;

}  // namespace apps
