#include "dsp/io/toml_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

[[noreturn]] void refuse(const std::string& name, std::ptrdiff_t line, std::string_view what) {
  throw Fault(FaultKind::usage, "config.syntax", fmt::format("{}:{}: {}", name, line, what));
}

/// Length of the string in quotes that begins `text`; an open one goes to the end of its line, or of the text.
std::size_t quoted_length(std::string_view text) {
  const char quote = text.front();
  const bool multiline = text.starts_with(std::string(3, quote));
  for (std::size_t i = multiline ? 3 : 1; i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\') {
      ++i;
    } else if (!multiline) {
      if (text[i] == quote) return i + 1;
      if (text[i] == '\n') return i;
    } else if (text.substr(i).starts_with(std::string(3, quote))) {
      i += 3;  // two more quotes may come before the three that close
      for (int more = 0; more < 2 && i < text.size() && text[i] == quote; ++more) ++i;
      return i;
    }
  }
  return text.size();
}

/// Whether a character may lie within a key or between its parts; a number has one dot, a key one less than parts.
bool belongs_to_key(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == ' ' || c == '\t' ||
         static_cast<unsigned char>(c) >= 0x80;
}

/// Refuses what is beyond the limits of a document, at the first line that is.
void check_limits(std::string_view text, const std::string& name) {
  if (text.size() > most_toml_bytes)
    refuse(name, 1, fmt::format("the document has {} bytes, want at most {}", text.size(), most_toml_bytes));
  int dots = 0, brackets = 0, entries = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size());
    } else if (c == '"' || c == '\'') {
      i += quoted_length(text.substr(i));
    } else {
      dots = c == '.' ? dots + 1 : belongs_to_key(c) ? dots : 0;
      const bool opens = c == '[' || c == '{';
      brackets += opens ? 1 : c == ']' || c == '}' ? -1 : 0;
      if (opens || c == '=' || c == ',') ++entries;
      ++i;
    }
    const bool fits = dots < most_key_parts && brackets <= most_brackets && entries <= most_entries;
    if (fits) continue;
    refuse(name, 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(i), '\n'),
           dots >= most_key_parts ? fmt::format("a key of more than {} parts with dots between them", most_key_parts)
           : brackets > most_brackets
               ? fmt::format("values within one another more than {} deep", most_brackets)
               : fmt::format("more than {} keys, tables and elements. Leave out what is no setting", most_entries));
  }
}

}  // namespace

toml::table parse_toml(std::string_view text, const std::string& name) {
  check_limits(text, name);
  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    const bool bare_text = error.description().find("could not determine value type") != std::string_view::npos;
    refuse(name, error.source().begin.line,
           clean_name(error.description()) + (bare_text ? ". A text stands in quotes: key = \"text\"" : ""));
  }
}

}  // namespace dsp
