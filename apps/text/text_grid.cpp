#include "apps/text/text_grid.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace apps {
namespace {

/// Characters, not bytes.
std::size_t length(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u; }));
}

std::string cut(const std::string& text, std::size_t most) {
  constexpr std::size_t dots = 3;
  if (length(text) <= most) return text;
  std::string shorter = text;
  while (length(shorter) + dots > most) {
    while ((static_cast<unsigned char>(shorter.back()) & 0xc0u) == 0x80u) shorter.pop_back();
    shorter.pop_back();
  }
  return shorter + "...";
}

std::string padded(const std::string& text, std::size_t width, bool right) {
  const std::string blanks(width - std::min(width, length(text)), ' ');
  return right ? blanks + text : text + blanks;
}

}  // namespace

TextGrid transposed(const TextGrid& grid) {
  TextGrid turned{grid.corner, grid.rows, grid.columns, {}};
  for (std::size_t column = 0; column < grid.columns.size(); ++column) {
    turned.cells.emplace_back();
    for (const auto& row : grid.cells) turned.cells.back().push_back(row[column]);
  }
  return turned;
}

std::string to_text(const TextGrid& grid, std::size_t width) {
  constexpr std::size_t indent = 2, gap = 2, widest_head = 40;
  std::size_t head = length(grid.corner);
  for (const std::string& row : grid.rows) head = std::max(head, std::min(length(row), widest_head));
  const std::size_t room = width - indent - head - gap;
  std::vector<std::size_t> widths;
  for (std::size_t column = 0; column < grid.columns.size(); ++column) {
    widths.push_back(length(grid.columns[column]));
    for (const auto& row : grid.cells) widths.back() = std::max(widths.back(), length(row[column]));
    widths.back() = std::min(widths.back(), room);
  }
  std::string text;
  for (std::size_t first = 0; first < grid.columns.size();) {
    std::size_t last = first, used = 0;
    while (last < widths.size() && (last == first || used + gap + widths[last] <= room))
      used += (last == first ? 0 : gap) + widths[last], ++last;
    const auto line = [&](const std::string& name, const std::vector<std::string>& cells) {
      std::string one = std::string(indent, ' ') + padded(cut(name, head), head, false);
      for (std::size_t column = first; column < last; ++column)
        one += std::string(gap, ' ') + padded(cut(cells[column], widths[column]), widths[column], true);
      return one.substr(0, one.find_last_not_of(' ') + 1) + "\n";
    };
    text += (first == 0 ? "" : "\n") + line(grid.corner, grid.columns);
    for (std::size_t row = 0; row < grid.rows.size(); ++row) text += line(grid.rows[row], grid.cells[row]);
    first = last;
  }
  return text;
}

}  // namespace apps
