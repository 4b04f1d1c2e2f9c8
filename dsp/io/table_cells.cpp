#include "dsp/io/table_cells.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>

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
  std::string point;
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
  for (const char* word : {"NA", "na", "N/A", "n/a", "NULL", "null"})
    if (text == word) return Cell::missing;
  return Cell::bad;
}

double last_digit(std::string_view number) {
  const auto exponent = std::min(number.find_first_of("eE"), number.size());
  const auto mark = number.find_first_of(".,");
  int power = 0;
  if (exponent + 1 < number.size()) {
    const auto digits = number.substr(exponent + 1 + (number[exponent + 1] == '+' ? 1 : 0));
    std::from_chars(digits.data(), digits.data() + digits.size(), power);
  }
  return std::pow(10.0, power - (mark < exponent ? static_cast<int>(exponent - mark - 1) : 0));
}

}  // namespace dsp
