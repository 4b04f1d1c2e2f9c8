#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/input_file.hpp"

namespace dsp {

/// How a text table is written.
struct TableLayout {
  std::string format;    ///< "CSV", "text", "LabVIEW"
  char separator = ',';  ///< ' ': any run of blanks
  bool decimal_comma = false;
  bool comments_behind = false;  ///< fields beyond num_columns are remarks
  int num_columns = 0;
  std::vector<std::string> columns;  ///< names, empty where the file has none
  std::vector<std::string> units;    ///< from the names or a line of their own
  std::vector<bool> partial;         ///< columns that hold something else than one number a row
  std::vector<bool> moments;         ///< columns of dates and times of day
  bool named = false;
  std::uint64_t data_offset = 0;            ///< first byte of the first row
  std::int64_t first_line = 1;              ///< its line number
  int time_column = -1;                     ///< by its name, or as the first that holds times of day
  int clock_like_column = -1;               ///< without names: the only one whose first values could be a clock's
  std::optional<std::int64_t> first_day{};  ///< of the first row, since 1970-01-01, where a column is of dates alone
  std::optional<double> rate_hz;            ///< the header's own
};

/// Looks at the beginning of a text file: separator, decimal mark, names, where the numbers begin.
/// Throws Fault container.unknown, table.header (input).
[[nodiscard]] TableLayout table_layout(const InputFile& file);

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
/// Reads one field; missing (empty, NaN, NA, null): NaN. A number too large for a double is bad, one too small is 0.
[[nodiscard]] Cell parse_cell(std::string_view field, bool decimal_comma, double& value);

/// What the last printed digit of a number means: 1e-6 for "0.000312", 1e-11 for "1.953125E-5".
[[nodiscard]] double last_digit(std::string_view number);

/// The roundest rate within `relative` of `rate_hz`: a whole number with as many zeros at its end as possible, else the
/// fraction with the smallest denominator up to 1000, else the rate itself. 3199.98 within 1e-4 is 3200.
[[nodiscard]] double roundest_rate(double rate_hz, double relative);

}  // namespace dsp
