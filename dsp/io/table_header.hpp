#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/io/table_style.hpp"

namespace dsp {

/// What lines above the rows of a table say.
struct TableHeader {
  std::vector<std::string_view> names{};  ///< cells, as many as columns; empty: none
  std::vector<std::string> units{};       ///< likewise, empty where there is no line of them
  std::optional<double> rate_hz{};
  std::vector<const TableLine*> skipped{};  ///< lines of which nothing was taken
  const TableLine* misfit = nullptr;  ///< the line above the rows, where it has several words and not as many as they
};

/// Whether a text is what files call the step between samples (true) or their rate (false); nothing where it is
/// neither.
[[nodiscard]] std::optional<bool> is_step_key(std::string_view text);

/// `above`: the lines before the first row; the names are in line number `header_row` where that is not 0.
[[nodiscard]] TableHeader table_header(const std::vector<TableLine>& above, const TableStyle& style,
                                       std::int64_t header_row);

}  // namespace dsp
