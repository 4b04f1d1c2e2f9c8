#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/input_file.hpp"
#include "dsp/io/table_cells.hpp"

namespace dsp {

/// One line at the beginning of a text file.
struct TableLine {
  std::string text;     ///< UTF-8, also where the file is in Latin-1
  std::int64_t number;  ///< from 1
  std::uint64_t offset;
  [[nodiscard]] bool is_comment() const;  ///< begins with # or %
  [[nodiscard]] bool is_blank() const;
};
/// The first lines, at most 4 MiB of them; those up to number `skipped` left out, as well as a first "sep=;" of
/// spreadsheets.
[[nodiscard]] std::vector<TableLine> first_lines(const InputFile& file, std::size_t count, std::int64_t skipped);

/// How cells are separated and numbers written, and what rows look like.
struct TableStyle {
  char separator = ',';  ///< ' ': any run of blanks
  bool decimal_comma = false;
  int num_columns = 0;          ///< 0: no line is a row
  std::vector<bool> is_text{};  ///< columns of words

  /// The cells of a line; an empty one behind the last separator is none, nor are
  /// those beyond the columns.
  [[nodiscard]] std::vector<std::string_view> cells(std::string_view line) const;
  /// As many cells as columns, or further ones that are empty, every one a number, a moment or missing, but in columns
  /// of words; not all of them missing.
  [[nodiscard]] bool is_row(std::string_view line) const;
};

/// The style in which most cells of most lines are numbers. A single column counts half: "1,2" is two numbers before it
/// is 1.2. Columns of words are those of at least three rows, and of remarks here and there.
[[nodiscard]] TableStyle table_style(const std::vector<TableLine>& lines);

/// ": in line 3, column 2 is 'abc'": the first cell that is no number, in the last line that has some, read in the
/// style that leaves fewest such cells; empty where there is none.
[[nodiscard]] std::string why_no_row(const InputFile& file, const std::vector<TableLine>& lines);

}  // namespace dsp
