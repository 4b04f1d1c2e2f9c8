#pragma once
#include <string>
#include <string_view>

namespace apps {

/// Text from a file, fit for a terminal and for JSON: valid UTF-8 (anything else becomes U+FFFD), control and
/// direction-changing characters as \xNN or \u{NNNN}, cut beyond `longest` bytes with "..." at the end.
[[nodiscard]] std::string printable(std::string_view text, std::size_t longest = 4000);

}  // namespace apps
