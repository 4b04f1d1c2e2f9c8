#include "apps/text/wrapped_text.hpp"

namespace apps {

std::vector<std::string> wrapped(const std::string& text, std::size_t most) {
  std::vector<std::string> lines;
  std::size_t at = 0;
  while (text.size() - at > most) {
    const std::size_t space = text.rfind(' ', at + most);
    const bool cut = space == std::string::npos || space <= at;
    std::size_t end = cut ? at + most : space;
    while (cut && end > at + 1 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
    lines.push_back(text.substr(at, end - at));
    at = cut ? end : end + 1;
  }
  lines.push_back(text.substr(at));
  return lines;
}

}  // namespace apps
