#include "apps/process/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

namespace apps {
namespace {

struct Decoded {
  std::uint32_t code_point = 0;
  std::size_t num_bytes = 0;  // 0: not UTF-8
};

Decoded decode(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return {first, 1};
  const std::size_t size = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || size > text.size()) return {};
  std::uint32_t code_point = first & (0x7Fu >> size);
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {};
    code_point = (code_point << 6) | (byte(i) & 0x3F);
  }
  const bool overlong = (size == 3 && code_point < 0x800) || (size == 4 && code_point < 0x10000);
  const bool surrogate = code_point >= 0xD800 && code_point <= 0xDFFF;
  return overlong || surrogate || code_point > 0x10FFFF ? Decoded{} : Decoded{code_point, size};
}

bool turns_the_text(std::uint32_t c) {
  return (c >= 0x202A && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069) || c == 0x200E || c == 0x200F || c == 0x2028 ||
         c == 0x2029;
}

bool is_control(std::uint32_t c) {
  return c < 0x20 || (c >= 0x7F && c < 0xA0);
}

std::string escaped(std::uint32_t c) {
  return is_control(c) ? fmt::format("\\x{:02x}", c) : fmt::format("\\u{{{:04x}}}", c);
}
std::string escaped_in_json(std::uint32_t c) {
  return fmt::format("\\u{:04x}", c);
}

/// Moves the character that begins `text` to the end of `result`, in printable form.
void move_character(std::string_view& text, std::string& result, std::string (*escape)(std::uint32_t)) {
  const Decoded next = decode(text);
  if (next.num_bytes == 0)
    result += "\xEF\xBF\xBD";
  else if (is_control(next.code_point) || turns_the_text(next.code_point))
    result += escape(next.code_point);
  else
    result += text.substr(0, next.num_bytes);
  text.remove_prefix(std::max<std::size_t>(next.num_bytes, 1));
}

std::string lines(std::string_view text, std::string (*escape)(std::uint32_t)) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    if (text.front() != '\n') {
      move_character(text, result, escape);
      continue;
    }
    result += '\n';
    text.remove_prefix(1);
  }
  return result;
}

}  // namespace

std::string printable(std::string_view text, std::size_t longest) {
  std::string result;
  while (!text.empty()) {
    if (result.size() >= longest) return result + "...";
    move_character(text, result, escaped);
  }
  return result;
}

std::string printable_lines(std::string_view text) {
  return lines(text, escaped);
}

std::string printable_json(std::string_view document) {
  return lines(document, escaped_in_json);
}

}  // namespace apps
