#include "apps/config/term_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <sstream>
#include <string_view>

#include "dsp/io/small_file.hpp"
#include "dsp/values/fault.hpp"

namespace apps {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\n";
  const std::size_t from = std::min(text.find_first_not_of(blanks), text.size());
  return text.substr(from, text.find_last_not_of(blanks) + 1 - from);
}

/// A dot before letters begins no number: such a text is the name of a file.
bool looks_like_a_file(const std::string& argument) {
  const std::size_t dot = argument.rfind('.');
  return argument.find_first_of(",(") == std::string::npos && dot + 1 < argument.size() && dot != std::string::npos &&
         std::isalpha(static_cast<unsigned char>(argument[dot + 1])) != 0;
}

/// Terms separated by commas outside brackets.
std::vector<std::string> split_terms(const std::string& list) {
  std::vector<std::string> terms(1);
  int depth = 0;
  for (const char c : list) {
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (c == ',' && depth == 0)
      terms.emplace_back();
    else
      terms.back() += c;
  }
  for (std::size_t i = 0; i < terms.size(); ++i) {
    terms[i] = trimmed(terms[i]);
    if (terms[i].empty())
      throw dsp::Fault(dsp::FaultKind::usage, "term.syntax",
                       fmt::format("--terms: term {} of {} is empty.", i + 1, terms.size()));
  }
  return terms;
}

}  // namespace

std::vector<std::string> read_terms(const std::string& argument) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(argument, ignored) && !looks_like_a_file(argument))
    return split_terms(argument);
  std::vector<std::string> terms;
  std::istringstream file(dsp::read_small_file(
      argument, {.kind = dsp::FaultKind::usage, .fault = "config.file", .wanted = "a file of --terms"}));
  for (std::string line; std::getline(file, line);) {
    line.erase(std::min(line.find('#'), line.size()));
    if (!trimmed(line).empty()) terms.emplace_back(trimmed(line));
  }
  return terms;
}

}  // namespace apps
