#pragma once
#include <string>
#include <vector>

namespace apps {

/// Cells under column heads and beside row heads, as text.
struct TextGrid {
  std::string corner;  ///< over the row heads
  std::vector<std::string> columns, rows;
  std::vector<std::vector<std::string>> cells;  ///< a vector for each row
};

[[nodiscard]] TextGrid transposed(const TextGrid& grid);
/// Lines of at most `width` columns: what does not fit beside one another goes below, under the row heads again. A head
/// or cell that is wider alone is cut with "...".
[[nodiscard]] std::string to_text(const TextGrid& grid, std::size_t width = 120);

}  // namespace apps
