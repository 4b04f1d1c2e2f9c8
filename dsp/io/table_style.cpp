#include "dsp/io/table_style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <tuple>

#include "dsp/io/moment.hpp"
#include "dsp/io/text_lines.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

struct Marks {
  char separator;
  bool decimal_comma;
};
// In order of trust: what a comma means is least clear.
constexpr std::array styles{Marks{'\t', false}, Marks{'\t', true}, Marks{';', false},
                            Marks{';', true},   Marks{',', false}, Marks{',', true},
                            Marks{' ', false},  Marks{' ', true},  Marks{'|', false}};

enum class Holds { number, missing, blank, mark, text };  // mark: --, ****, OL: no evidence of a row of numbers
Holds holds(std::string_view cell, bool decimal_comma) {
  double value = 0.0;
  const Cell read = parse_cell(cell, decimal_comma, value);
  if (read == Cell::missing) {
    const std::string text = lower(unquoted(cell));
    const bool is_mark = text.find("nan") == text.npos && text.find("inf") == text.npos && text != "na" &&
                         text != "n/a" && text != "null";
    return text.empty() ? Holds::blank : is_mark ? Holds::mark : Holds::missing;
  }
  return read == Cell::number || parse_moment(cell) ? Holds::number : Holds::text;
}

std::vector<std::string_view> all_cells(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  std::string_view cell;
  for (Fields walk(line, separator); walk.next(cell);) cells.push_back(cell);
  return cells;
}

// The lines that have a number, cell by cell.
std::vector<std::vector<Holds>> numeric_lines(const std::vector<TableLine>& lines, const Marks& marks) {
  std::vector<std::vector<Holds>> found;
  for (const TableLine& line : lines) {
    if (line.is_blank() || line.is_comment()) continue;
    std::vector<Holds> kinds;
    for (const auto cell : all_cells(line.text, marks.separator)) kinds.push_back(holds(cell, marks.decimal_comma));
    const auto has_number = [](Holds kind) { return kind == Holds::number || kind == Holds::missing; };
    if (std::any_of(kinds.begin(), kinds.end(), has_number)) found.push_back(std::move(kinds));
  }
  return found;
}

bool has_words(const std::vector<Holds>& line) {
  return std::find(line.begin(), line.end(), Holds::text) != line.end();
}

// How many cells most lines have; of two widths that are as frequent, the larger. Where lines of several numbers and no
// words follow each other those count alone, however many of a word and a number are above them.
struct Width {
  std::size_t cells = 0;
  bool is_plain = false;  // of such lines
};
Width usual_width(const std::vector<std::vector<Holds>>& lines) {
  constexpr std::size_t fewest_rows = 3;
  std::map<std::size_t, int> counts, plain;
  std::size_t in_a_row = 0, longest = 0;
  const std::vector<Holds>* before = nullptr;
  for (const auto& line : lines) {
    ++counts[line.size()];
    const bool is_plain = line.size() > 1 && !has_words(line);
    if (is_plain) ++plain[line.size()];
    in_a_row = !is_plain ? 0 : before != nullptr && before->size() == line.size() ? in_a_row + 1 : 1;
    longest = std::max(longest, in_a_row);
    before = &line;
  }
  if (longest >= fewest_rows) counts = plain;
  const auto most = std::max_element(counts.rbegin(), counts.rend(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return {most == counts.rend() ? 0 : most->first, longest >= fewest_rows};
}

struct Rated {
  TableStyle style;
  bool is_plain = false;
  double score = 0.0;  // cells that are numbers, as a share of a line, summed over the lines that are rows
};
Rated rated(const std::vector<TableLine>& lines, const Marks& marks) {
  Rated result{{marks.separator, marks.decimal_comma}};
  const std::vector<std::vector<Holds>> found = numeric_lines(lines, marks);
  const Width usual = usual_width(found);
  std::size_t width = usual.cells;
  result.is_plain = usual.is_plain;
  const auto num_lines =
      std::count_if(found.begin(), found.end(), [&](const auto& one) { return one.size() == width; });
  constexpr std::ptrdiff_t fewest_rows_with_words = 3;
  const std::size_t full_width = width;
  const auto is_blank_column = [&](std::size_t column) {
    return std::all_of(found.begin(), found.end(),
                       [&](const auto& line) { return line.size() != full_width || line[column] == Holds::blank; });
  };
  while (width > 1 && num_lines > 0 && is_blank_column(width - 1)) --width;  // separators end every line
  const auto fits = [&](const std::vector<Holds>& line) {
    return line.size() >= width && std::all_of(line.begin() + static_cast<std::ptrdiff_t>(width), line.end(),
                                               [](Holds kind) { return kind == Holds::blank; });
  };
  std::vector<bool>& is_text = result.style.is_text;
  for (std::size_t i = 0; i < width; ++i) {
    std::ptrdiff_t words = 0, numbers = 0, blanks = 0, since = 0;  // the last of them
    for (const auto& line : found) {
      if (!fits(line)) continue;
      const bool is_word = line[i] == Holds::text;
      numbers += line[i] == Holds::number || line[i] == Holds::missing ? 1 : 0;
      blanks += line[i] == Holds::blank ? 1 : 0;
      words += is_word ? 1 : 0;
      since = is_word ? 0 : since + 1;
    }
    constexpr std::ptrdiff_t few = 10;  // times fewer than lines: remarks, or keys and values beside the first rows
    const bool are_remarks =
        words > 0 && (numbers == 0 || few * (words + numbers) < num_lines) && blanks >= fewest_rows_with_words;
    is_text.push_back(
        marks.separator != ' ' &&
        (are_remarks || (words >= fewest_rows_with_words && 2 * words > num_lines && since < fewest_rows_with_words)));
  }
  for (const auto& line : found) {
    if (!fits(line)) continue;
    std::size_t good = 0, bad = 0;
    for (std::size_t i = 0; i < width; ++i) {
      good += line[i] != Holds::text ? 1 : 0;
      bad += line[i] == Holds::text && !is_text[i] ? 1 : 0;
    }
    if (bad == 0) result.score += static_cast<double>(good) / static_cast<double>(width) * (width > 1 ? 2.0 : 1.0);
  }
  if (result.score > 0.0) result.style.num_columns = static_cast<int>(width);
  return result;
}

std::string from_latin1(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      result += c;
    } else {
      result += static_cast<char>(0xc0 | (byte >> 6));
      result += static_cast<char>(0x80 | (byte & 0x3f));
    }
  }
  return result;
}

bool is_utf8(std::string_view text) {
  int behind = 0;  // bytes that must follow
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xc0) == 0x80) {
      if (behind-- == 0) return false;
    } else if (behind > 0) {
      return false;
    } else {
      behind = byte < 0x80 ? 0 : byte >= 0xf0 ? 3 : byte >= 0xe0 ? 2 : 1;
    }
  }
  return behind == 0;
}

// "sep=;", which tells a spreadsheet what the separator is.
bool is_separator_line(std::string_view text) {
  constexpr std::size_t longest = 5;
  const auto line = unquoted(text);
  return line.starts_with("sep=") && line.size() <= longest;
}

/// What keeps a line from being a row of numbers, as one style reads it.
struct BadCells {
  int numbers = 0, bad = 0;
  std::size_t first = 0;  // 0-based, of the bad ones
  std::string_view text;
};
BadCells bad_cells(std::string_view line, const Marks& marks) {
  BadCells found;
  std::size_t column = 0;
  for (const auto cell : all_cells(line, marks.separator)) {
    const Holds kind = holds(cell, marks.decimal_comma);
    if (kind == Holds::text && found.bad++ == 0) found.first = column, found.text = cell;
    if (kind == Holds::number) ++found.numbers;
    ++column;
  }
  return found;
}

}  // namespace

bool TableLine::is_comment() const {
  const auto plain = trimmed(text);
  return plain.starts_with('#') || plain.starts_with('%');
}

bool TableLine::is_blank() const {
  return trimmed(text).empty();
}

std::vector<TableLine> first_lines(const InputFile& file, std::size_t count, std::int64_t skipped) {
  constexpr std::size_t most_bytes = std::size_t{4} << 20;
  std::vector<TableLine> lines;
  TextLines reader(file);
  std::size_t num_bytes = 0;
  for (std::string_view text; lines.size() < count && num_bytes < most_bytes && reader.next(text);) {
    num_bytes += text.size();
    auto offset = reader.offset();
    if (reader.number() == 1 && text.starts_with("\xef\xbb\xbf")) {
      text.remove_prefix(3);
      offset += 3;
    }
    if (reader.number() <= skipped || (reader.number() == 1 && is_separator_line(text))) continue;
    lines.push_back({is_utf8(text) ? std::string(text) : from_latin1(text), reader.number(), offset});
  }
  return lines;
}

std::vector<std::string_view> TableStyle::cells(std::string_view line) const {
  std::vector<std::string_view> found = all_cells(line, separator);
  const auto width = static_cast<std::size_t>(num_columns);
  for (bool is_last = true; found.size() > 1 && (is_last || found.size() > width) && trimmed(found.back()).empty();
       is_last = false)
    found.pop_back();
  return found;
}

bool TableStyle::is_row(std::string_view line) const {
  const std::vector<std::string_view> found = all_cells(line, separator);
  const auto width = static_cast<std::size_t>(num_columns);
  bool any = false;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Holds kind = holds(found[i], decimal_comma);
    if (i >= width && kind != Holds::blank) return false;
    if (kind == Holds::text && !is_text[i]) return false;
    any = any || kind == Holds::number || kind == Holds::missing;
  }
  return any && found.size() >= width;
}

TableStyle table_style(const std::vector<TableLine>& lines) {
  Rated best;
  for (const Marks& marks : styles)
    if (Rated found = rated(lines, marks);
        found.score > 0.0 && std::tie(found.is_plain, found.score) > std::tie(best.is_plain, best.score))
      best = std::move(found);
  return best.style;
}

std::string why_no_row(const InputFile& file, const std::vector<TableLine>& lines) {
  for (const int least_numbers : {1, 0})
    for (auto line = lines.rbegin(); line != lines.rend(); ++line) {
      std::optional<BadCells> best;
      if (line->is_blank() || line->is_comment()) continue;
      for (const Marks& marks : styles) {
        if (all_cells(line->text, marks.separator).size() < 2 || marks.separator == ' ') continue;
        const BadCells found = bad_cells(line->text, marks);
        const bool is_better =
            !best || found.bad < best->bad || (found.bad == best->bad && found.numbers > best->numbers);
        if (found.bad > 0 && found.numbers >= least_numbers && is_better) best = found;
      }
      if (best)
        return fmt::format(": in line {}, column {} is {}", line->number, best->first + 1,
                           file.quoted(unquoted(best->text)));
    }
  return "";
}

}  // namespace dsp
