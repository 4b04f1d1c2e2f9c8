#pragma once
#include <string>
#include <string_view>

namespace apps {

/// Text from a file, fit for a terminal and for JSON: valid UTF-8 (anything else becomes U+FFFD), control and
/// direction-changing characters as \xNN or \u{NNNN}, cut beyond `longest` bytes with "..." at the end.
[[nodiscard]] std::string printable(std::string_view text, std::size_t longest = 4000);

/// The same for a text of several lines, which keeps its line ends and is never cut.
[[nodiscard]] std::string printable_lines(std::string_view text);

/// A JSON document fit for a terminal: such characters, which only its strings can hold, as \uNNNN.
[[nodiscard]] std::string printable_json(std::string_view document);

}  // namespace apps
