#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/input_file.hpp"
#include "dsp/io/table_cells.hpp"

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

/// The roundest rate within `relative` of `rate_hz`: a whole number with as many zeros at its end as possible, else the
/// fraction with the smallest denominator up to 1000, else the rate itself. 3199.98 within 1e-4 is 3200.
[[nodiscard]] double roundest_rate(double rate_hz, double relative);

}  // namespace dsp
