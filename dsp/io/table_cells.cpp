#include "dsp/io/table_cells.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace dsp {

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view unquoted(std::string_view text) {
  text = trimmed(text);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = trimmed(text.substr(1, text.size() - 2));
  return text;
}

bool Fields::next(std::string_view& field) {
  if (separator_ == ' ') rest_ = trimmed(rest_);
  if (done_ || (separator_ == ' ' && rest_.empty())) return false;
  std::size_t from = 0;
  if (const auto start = rest_.find_first_not_of(' '); start != std::string_view::npos && rest_[start] == '"')
    from = std::min(rest_.find('"', start + 1), rest_.size());
  auto end = separator_ == ' ' ? rest_.find_first_of(" \t", from) : rest_.find(separator_, from);
  done_ = end == std::string_view::npos;
  end = std::min(end, rest_.size());
  field = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  return true;
}

namespace {

/// "1234,5" for "1.234,5" with `mark` '.': without the marks between thousands; empty where there are none, or not
/// every three digits, or no decimals behind them: 1.234 may be less than two.
std::string without_grouping(std::string_view text, char mark, char decimal) {
  constexpr std::size_t group = 3;
  const auto point = text.find(decimal);
  std::string plain;
  std::size_t digits = 0;  // since the last mark
  bool is_grouped = false;
  for (const char c : text.substr(0, point)) {
    if (c == mark) {
      if (is_grouped ? digits != group : digits == 0 || digits > group) return "";
      is_grouped = true;
      digits = 0;
    } else {
      plain += c;
      digits += c >= '0' && c <= '9' ? 1 : 0;
    }
  }
  return is_grouped && digits == group && point != text.npos ? plain.append(text.substr(point)) : "";
}

/// Signs that word processors and spreadsheets put into numbers, as plain ones: a minus of typography, blanks that do
/// not break lines.
std::string with_plain_signs(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> signs{
      {{"\xe2\x88\x92", "-"}, {"\xc2\xa0", " "}, {"\xe2\x80\xaf", " "}, {"\xe2\x80\x89", " "}, {"\xe2\x80\x99", "'"}}};
  std::string plain(text);
  for (const auto& [sign, meant] : signs)
    for (auto at = plain.find(sign); at != plain.npos; at = plain.find(sign, at + 1))
      plain.replace(at, sign.size(), meant);
  return std::string(trimmed(plain));
}

/// "20006.9" for "20 006.9" and "20'006.9": marks that can be nothing else between groups of three digits. As it is
/// where they are not between such.
std::string without_spaced_grouping(const std::string& text) {
  const auto is_digit = [&](std::size_t i) { return i < text.size() && text[i] >= '0' && text[i] <= '9'; };
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != ' ' && text[i] != '\'') {
      plain += text[i];
      continue;
    }
    const bool is_group = i > 0 && is_digit(i - 1) && is_digit(i + 1) && is_digit(i + 2) && is_digit(i + 3);
    if (!is_group || is_digit(i + 4)) return text;
  }
  return plain;
}

/// What instruments and spreadsheets print where they have no value: words, errors (#N/A), marks alone (--, ****).
bool is_missing_word(std::string_view text) {
  constexpr std::array<std::string_view, 16> words{"na",  "n/a",   "n.a.", "null",   "none",     "ol",
                                                   "o.l", "ovl",   "ovld", "over",   "overload", "overflow",
                                                   "err", "error", "inv",  "invalid"};
  constexpr std::size_t longest = 16;
  if (text.size() > longest) return false;
  if (text.find_first_not_of("-*.?#/_") == text.npos) return true;
  if (text.front() == '#' && text.find_first_of("!?/") != text.npos) return true;
  std::string word(text.substr(text.find_first_not_of("+-") == text.npos ? 0 : text.find_first_not_of("+-")));
  for (char& c : word) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

Cell parse_cell(std::string_view field, bool decimal_comma, double& value) {
  value = std::numeric_limits<double>::quiet_NaN();
  const auto parse = [&](std::string_view text) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (end != text.data() + text.size() || text.empty()) return Cell::bad;
    if (error == std::errc::result_out_of_range) {  // both ways: 1e-400 is 0, 1e400 is nothing
      value = 0.0;
      return text.find("e-") != text.npos || text.find("E-") != text.npos ? Cell::number : Cell::bad;
    }
    if (error != std::errc()) return Cell::bad;
    return std::isfinite(value) ? Cell::number : Cell::missing;
  };
  if (!decimal_comma && parse(field) == Cell::number) return Cell::number;
  value = std::numeric_limits<double>::quiet_NaN();
  auto text = unquoted(field);
  if (text.starts_with('+') && text.size() > 1 && text[1] != '-') text.remove_prefix(1);
  if (text.empty()) return Cell::missing;
  constexpr std::size_t longest_number = 64;
  std::string plain, point;
  if (text.size() <= longest_number && text.find_first_of(" '\xe2\xc2") != text.npos) {
    plain = without_spaced_grouping(with_plain_signs(text));
    text = plain;
  }
  if (text.find(',') != text.npos) point = without_grouping(text, decimal_comma ? '.' : ',', decimal_comma ? ',' : '.');
  if (decimal_comma) {
    if (point.empty()) point = text;
    if (point.find('.') != std::string::npos) return Cell::bad;
    std::replace(point.begin(), point.end(), ',', '.');
  }
  if (!point.empty()) text = point;
  Cell cell = parse(text);
  if (const auto exponent = text.find_first_of("Dd"); cell == Cell::bad && exponent != text.npos && exponent > 0) {
    std::string written(text);  // 1.5D-03, as Fortran has it
    written[exponent] = 'e';
    cell = parse(written);
  }
  if (cell != Cell::number) value = std::numeric_limits<double>::quiet_NaN();
  if (cell != Cell::bad) return cell;
  return is_missing_word(text) ? Cell::missing : Cell::bad;
}

double last_digit(std::string_view number) {
  const auto exponent = std::min(number.find_first_of("eE"), number.size());
  const auto mark = number.find_first_of(".,");
  constexpr int most = 10'000;  // far outside all numbers
  int power = 0;
  if (exponent + 1 < number.size()) {
    const auto digits = number.substr(exponent + 1 + (number[exponent + 1] == '+' ? 1 : 0));
    std::from_chars(digits.data(), digits.data() + digits.size(), power);
    power = std::clamp(power, -most, most);
  }
  constexpr std::array usual{1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9};
  const int decimals = (mark < exponent ? static_cast<int>(exponent - mark - 1) : 0) - power;
  return decimals >= 0 && std::cmp_less(decimals, usual.size()) ? usual[static_cast<std::size_t>(decimals)]
                                                                : std::pow(10.0, -decimals);
}

}  // namespace dsp
