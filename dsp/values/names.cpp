#include "dsp/values/names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>

namespace dsp {
namespace {

// Length of the UTF-8 sequence that starts `text`, 0 if it is none (overlong forms, surrogates and beyond U+10FFFF are
// none).
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
  std::uint32_t code = first & (0xffu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0u) != 0x80u) return 0;
    code = (code << 6) | (byte(i) & 0x3fu);
  }
  constexpr std::array<std::uint32_t, 5> least{0, 0, 0x80, 0x800, 0x10000};
  return code >= least[length] && code <= 0x10ffff && (code < 0xd800 || code > 0xdfff) ? length : 0;
}

// U+0080 to U+009F: control codes of terminals too.
bool is_c1_control(std::string_view sequence) {
  return sequence.size() == 2 && sequence[0] == '\xc2' && static_cast<unsigned char>(sequence[1]) < 0xa0;
}

}  // namespace

std::string clean_name(std::string_view raw) {
  constexpr std::size_t most_characters = 200, dots = 3;
  while (!raw.empty() && (raw.front() == ' ' || raw.front() == '\t')) raw.remove_prefix(1);
  while (!raw.empty() && (raw.back() == ' ' || raw.back() == '\t')) raw.remove_suffix(1);
  std::string clean;
  std::size_t count = 0, cut = 0;  // characters so far; bytes of what fits with the dots
  while (!raw.empty()) {
    const auto length = utf8_length(raw);
    const auto sequence = raw.substr(0, std::max<std::size_t>(length, 1));
    const auto code = static_cast<unsigned char>(raw[0]);
    const bool control = length == 1 && (code < 0x20 || code == 0x7f), c1 = is_c1_control(sequence);
    if (length == 0)
      clean += "\xef\xbf\xbd";
    else if (control || c1)
      clean += fmt::format("\\x{:02x}", c1 ? static_cast<unsigned char>(sequence[1]) : code);
    else
      clean += sequence;
    count += control || c1 ? 4 : 1;
    if (count <= most_characters - dots) cut = clean.size();
    if (count > most_characters) return clean.substr(0, cut) + "...";
    raw.remove_prefix(sequence.size());
  }
  return clean;
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

std::string slug(std::string_view name) {
  constexpr std::size_t most_characters = 64;
  std::string result;
  for (const char c : name) {
    if (result.size() == most_characters) break;
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-')
      result += c;
    else if (c >= 'A' && c <= 'Z')
      result += static_cast<char>(c - 'A' + 'a');
    else if (!result.empty() && result.back() != '_')
      result += '_';
  }
  while (!result.empty() && (result.back() == '_')) result.pop_back();
  while (!result.empty() && result.front() == '-') result.erase(0, 1);  // a name must not look like an option
  if (result.empty()) return "unnamed";
  // Names some systems keep for devices: con, prn, aux, nul, com1, lpt1.
  constexpr std::array<std::string_view, 4> devices{"con", "prn", "aux", "nul"};
  const bool port = result.size() == 4 && (result.starts_with("com") || result.starts_with("lpt"));
  if (port || std::find(devices.begin(), devices.end(), result) != devices.end()) result += '_';
  return result;
}

std::string nearest(std::string_view word, const std::vector<std::string>& candidates) {
  const std::size_t reach = std::max<std::size_t>(2, word.size() / 3);
  std::size_t best = reach + 1;
  std::string found;
  for (const auto& candidate : candidates) {
    if (candidate.size() > word.size() + reach || word.size() > candidate.size() + reach) continue;
    // Levenshtein distance, one row at a time.
    std::vector<std::size_t> row(candidate.size() + 1);
    for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j < row.size(); ++j) {
        const std::size_t replaced = diagonal + (word[i - 1] == candidate[j - 1] ? 0 : 1);
        diagonal = row[j];
        row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
      }
    }
    if (row.back() < best && row.back() < std::max<std::size_t>(candidate.size(), 2)) {
      best = row.back();
      found = candidate;
    }
  }
  constexpr std::size_t enough = 3;  // letters to go by
  for (const auto& candidate : candidates)
    if (found.empty() && word.size() >= enough && candidate.starts_with(word)) found = candidate;
  return found;
}

}  // namespace dsp
