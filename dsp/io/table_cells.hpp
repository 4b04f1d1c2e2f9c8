#pragma once
#include <string_view>

namespace dsp {

/// Without blanks, tabs and carriage returns around it.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// The same, without a pair of quotes around it either.
[[nodiscard]] std::string_view unquoted(std::string_view text);

/// Field number `index` of a line is what lies between separators; quotes hide separators.
class Fields {
 public:
  Fields(std::string_view line, char separator) : rest_(line), separator_(separator) {}
  /// False when the line is used up. A line that ends in a separator ends in an empty field.
  bool next(std::string_view& field);

 private:
  std::string_view rest_;
  char separator_;
  bool done_ = false;
};

enum class Cell { number, missing, bad };
/// Reads one field; missing (empty, NaN, NA, null, OL, #N/A, --, ****): NaN. Thousands may be marked where decimals are
/// behind them, by blanks and apostrophes always. A number too large for a double is bad, one too small is 0.
[[nodiscard]] Cell parse_cell(std::string_view field, bool decimal_comma, double& value);

/// What the last printed digit of a number means: 1e-6 for "0.000312", 1e-11 for "1.953125E-5".
[[nodiscard]] double last_digit(std::string_view number);

}  // namespace dsp
