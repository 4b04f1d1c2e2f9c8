#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>

namespace apps {

/// A whole number in decimal digits, refused in one short line. For `transform`: leading zeros go, CLI11 would read
/// octal.
[[nodiscard]] CLI::Validator whole(std::uint64_t from, std::uint64_t to = std::numeric_limits<std::uint64_t>::max());

/// A finite number, zero or more, refused in one short line.
[[nodiscard]] CLI::Validator not_negative();

}  // namespace apps
