#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace apps {

/// Text as lines of at most so many bytes, broken at spaces; a word longer than a line is cut between characters.
[[nodiscard]] std::vector<std::string> wrapped(const std::string& text, std::size_t most);

}  // namespace apps
