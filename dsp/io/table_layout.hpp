#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/input_file.hpp"
#include "dsp/io/sample_source.hpp"
#include "dsp/io/table_style.hpp"

namespace dsp {

/// A column of a text table.
struct TableColumn {
  std::string name;            ///< empty where the file has none
  std::string unit;            ///< from the name or a line of units; empty: not known
  bool holds_moments = false;  ///< dates and times of day
  bool holds_text = false;     ///< words
  bool counts_rows = false;    ///< 1, 2, 3 ...
  /// Why it is no channel, as far as it is not a clock: "text", "run 2"; empty where it is one.
  std::string left_out{};
};

/// How a text table is written: what every reader of text gives, whatever the program that wrote it.
struct TableLayout {
  std::string format;  ///< "CSV", "text", "LabVIEW"
  TableStyle style;
  std::vector<TableColumn> columns;
  bool named = false;
  bool comments_behind = false;   ///< fields beyond the columns are remarks
  std::string header_again{};     ///< how a line begins that opens another header between rows; empty: none does
  std::string header_end{};       ///< how its last line but that of names begins
  std::string names_line{};       ///< without blanks around it; between rows it is none, as where a logger began anew
  int num_runs = 1;               ///< side by side
  bool is_one_run = false;        ///< the clock may end before the rows do: of several side by side
  std::uint64_t data_offset = 0;  ///< first byte of the first row
  std::uint64_t end_offset = 0;   ///< behind the last row
  std::int64_t first_line = 1;    ///< line number of the first row
  int time_column = -1;           ///< by its name, or as the first that holds times of day
  int clock_like_column = -1;     ///< without such a one: the only one whose first values could be a clock's
  std::optional<std::int64_t> first_day{};  ///< of the first row, since 1970-01-01, where a column is of dates alone
  std::optional<double> rate_hz{};          ///< the header's own
  std::vector<Check> checks{};              ///< what was skipped, as notes and warnings
};

/// Looks at the beginning and the end of a text file: separator, decimal mark, names and units, where the rows begin
/// and end. Names are in the last line of words above the rows that is as wide as they are; lines above it are read for
/// a rate and otherwise skipped with a note. `options` state header_row, skip_rows, run and the columns of a sidecar.
/// Throws Fault container.unknown, table.header (input), clock.run (input) where several runs are side by side.
[[nodiscard]] TableLayout table_layout(const InputFile& file, const OpenOptions& options);

/// The roundest rate within `relative` of `rate_hz`: a whole number with as many zeros at its end as possible, else the
/// fraction with the smallest denominator up to 1000, else the rate itself. 3199.98 within 1e-4 is 3200.
[[nodiscard]] double roundest_rate(double rate_hz, double relative);

}  // namespace dsp
