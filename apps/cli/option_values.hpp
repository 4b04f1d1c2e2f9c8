#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <string>

namespace apps {

/// Why a text is refused, in one short line; empty where it is taken. May write it in another way.
using ValueCheck = std::function<std::string(std::string& text)>;

/// A whole number in decimal digits. Leading zeros go: the parser would read octal.
[[nodiscard]] ValueCheck whole_number(std::uint64_t from, std::uint64_t to = std::numeric_limits<std::uint64_t>::max());

/// A finite number, zero or more.
[[nodiscard]] ValueCheck non_negative_number();
/// A finite number above zero.
[[nodiscard]] ValueCheck positive_number();

}  // namespace apps
