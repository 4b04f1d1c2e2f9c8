#include "dsp/io/table_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "dsp/fault.hpp"
#include "dsp/io/found_clock.hpp"
#include "dsp/io/moment.hpp"
#include "dsp/io/text_lines.hpp"
#include "dsp/io/units.hpp"
#include "dsp/names.hpp"

namespace dsp {
namespace {

struct Line {
  std::string text;
  std::int64_t number;
  std::uint64_t offset;
};

std::vector<std::string_view> fields_of(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  std::string_view field;
  for (Fields walk(line, separator); walk.next(field);) fields.push_back(field);
  if (fields.size() > 1 && trimmed(fields.back()).empty()) fields.pop_back();  // a separator at the end
  return fields;
}

bool is_row(std::string_view line, char separator, bool decimal_comma) {
  bool any = false;
  double value = 0;
  for (const auto field : fields_of(line, separator)) {
    const Cell cell = parse_cell(field, decimal_comma, value);
    if (cell == Cell::bad && !parse_moment(field)) return false;
    any = any || cell == Cell::number || (cell == Cell::missing && !unquoted(field).empty());  // NaN in words
  }
  return any;
}

struct Style {
  char separator;
  bool decimal_comma;
};
// In order of trust: what a comma means is least clear.
constexpr std::array styles{Style{'\t', false}, Style{'\t', true}, Style{';', false}, Style{';', true},
                            Style{',', false},  Style{' ', false}, Style{' ', true}};

// The style in which most lines are rows of one width. A single column counts half: "1,2" is two numbers before it
// is 1.2.
struct Guess {
  Style style{',', false};
  int num_columns = 0, score = 0;
};
Guess guess_style(const std::vector<Line>& lines) {
  Guess best;
  for (const auto style : styles) {
    std::vector<int> counts;
    for (const auto& line : lines)
      if (is_row(line.text, style.separator, style.decimal_comma))
        counts.push_back(static_cast<int>(fields_of(line.text, style.separator).size()));
    if (counts.empty()) continue;
    std::sort(counts.begin(), counts.end());
    const int width = counts[counts.size() / 2];
    const int agreeing = static_cast<int>(std::count(counts.begin(), counts.end(), width));
    const int score = width > 1 ? 2 * agreeing : agreeing;
    if (score > best.score) best = {style, width, score};
  }
  return best;
}

std::vector<Line> first_lines(const InputFile& file, std::size_t count) {
  std::vector<Line> lines;
  TextLines reader(file);
  for (std::string_view text; lines.size() < count && reader.next(text);) {
    auto offset = reader.offset();
    if (reader.number() == 1 && text.starts_with("\xef\xbb\xbf")) {
      text.remove_prefix(3);
      offset += 3;
    }
    lines.push_back({std::string(text), reader.number(), offset});
  }
  return lines;
}

bool is_comment(std::string_view text) {
  return text.starts_with('#') || text.starts_with('%');
}

void set_names(TableLayout& layout, const std::vector<std::string_view>& names) {
  layout.named = true;
  for (std::size_t i = 0; i < layout.columns.size(); ++i) {
    layout.columns[i] = clean_name(unquoted(names[i]));
    layout.units[i] = split_unit(layout.columns[i]).unit;
  }
}

// A second header line may hold the units.
bool set_units(TableLayout& layout, const std::vector<std::string_view>& texts) {
  std::vector<std::string> units;
  for (const auto text : texts) {
    auto unit = unquoted(text);
    if (unit.size() > 2 && (unit.front() == '(' || unit.front() == '[')) unit = unit.substr(1, unit.size() - 2);
    if (!unit.empty() && unit != "-" && !is_unit(unit)) return false;
    units.push_back(unit == "-" ? "" : std::string(unit));
  }
  layout.units = std::move(units);
  return true;
}

// The first column of numbers that is called time; one of moments where there is none.
void find_time(TableLayout& layout) {
  for (std::size_t i = 0; i < layout.columns.size(); ++i) {
    const bool better =
        layout.time_column < 0 || (layout.moments[static_cast<std::size_t>(layout.time_column)] && !layout.moments[i]);
    const bool in_time = layout.units[i].empty() || find_unit(layout.units[i]).si == "s";
    if (better && in_time && is_time_name(split_unit(layout.columns[i]).base)) layout.time_column = static_cast<int>(i);
  }
}

// The rows among the first lines, cell by cell.
template <class Visit>
void for_each_cell(const TableLayout& layout, const std::vector<Line>& lines, Visit&& visit) {
  for (const Line& line : lines) {
    const auto fields = fields_of(line.text, layout.separator);
    if (line.number < layout.first_line || is_comment(trimmed(line.text)) || fields.size() != layout.columns.size())
      continue;
    for (std::size_t i = 0; i < fields.size(); ++i) visit(i, fields[i]);
  }
}

// Columns of dates and times. The first with times of day is the clock, unless a column of numbers is called time.
void find_moments(TableLayout& layout, const std::vector<Line>& lines) {
  int first = -1;
  for_each_cell(layout, lines, [&](std::size_t i, std::string_view field) {
    double value = 0.0;
    if (layout.moments[i] || parse_cell(field, layout.decimal_comma, value) != Cell::bad) return;
    const auto moment = parse_moment(field);
    if (!moment) return;
    layout.moments[i] = true;
    layout.units[i].assign(1, 's');  // GCC 12 warns of = "s"
    if (!moment->has_time() && !layout.first_day) layout.first_day = moment->day;
    if (moment->has_time() && (first < 0 || static_cast<int>(i) < first)) first = static_cast<int>(i);
  });
  find_time(layout);
  const bool by_name = layout.time_column >= 0 && !layout.moments[static_cast<std::size_t>(layout.time_column)];
  if (first >= 0 && !by_name) layout.time_column = first;
}

// The only column that could be a clock, as far as its first rows tell.
void find_clock_like(TableLayout& layout, const std::vector<Line>& lines) {
  std::vector<std::vector<double>> columns(layout.columns.size());
  for_each_cell(layout, lines, [&](std::size_t i, std::string_view field) {
    (void)parse_cell(field, layout.decimal_comma, columns[i].emplace_back());
  });
  std::vector<int> found;
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (is_clock_like(columns[i])) found.push_back(static_cast<int>(i));
  if (found.size() == 1) layout.clock_like_column = found.front();  // of two, a person must say which
}

void size_columns(TableLayout& layout) {
  const auto count = static_cast<std::size_t>(layout.num_columns);
  layout.columns.resize(count);
  layout.units.resize(count);
  layout.partial.resize(count);
  layout.moments.resize(count);
}

/// What keeps a line from being a row of numbers, as one style reads it.
struct BadCells {
  int numbers = 0, bad = 0;
  std::size_t first = 0;  // 0-based, of the bad ones
  std::string_view text;
};
BadCells bad_cells(std::string_view line, const Style& style) {
  BadCells found;
  double value = 0.0;
  std::size_t column = 0;
  for (const auto field : fields_of(line, style.separator)) {
    const Cell cell = parse_cell(field, style.decimal_comma, value);
    const bool is_bad = cell == Cell::bad && !parse_moment(field);
    if (is_bad && found.bad++ == 0) found.first = column, found.text = field;
    if (!is_bad && cell != Cell::missing) ++found.numbers;
    ++column;
  }
  return found;
}

// The first cell that is no number, in the last line that has some, read in the style that leaves fewest such cells.
std::string why_no_row(const InputFile& file, const std::vector<Line>& lines) {
  for (const int least_numbers : {1, 0})
    for (auto line = lines.rbegin(); line != lines.rend(); ++line) {
      std::optional<BadCells> best;
      if (trimmed(line->text).empty() || is_comment(trimmed(line->text))) continue;
      for (const Style& style : styles) {
        if (fields_of(line->text, style.separator).size() < 2 || style.separator == ' ') continue;
        const BadCells found = bad_cells(line->text, style);
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

TableLayout csv_layout(const InputFile& file, const std::vector<Line>& lines) {
  const auto fault = [&](const Line& line, const std::string& what) {
    return Fault(FaultKind::input, "table.header", fmt::format("{}:{}: {}", file.name(), line.number, what));
  };
  const Guess guess = guess_style(lines);
  if (guess.score == 0)
    throw Fault(
        FaultKind::input, "container.unknown",
        fmt::format("{}: text, but no line of its first {} is a row of numbers{}. Read are sound files (WAV, RF64, "
                    "W64, CAF, FLAC, AIFF), MATLAB v5, CSV and LabVIEW text",
                    file.name(), lines.size(), why_no_row(file, lines)));
  TableLayout layout;
  layout.separator = guess.style.separator;
  layout.decimal_comma = guess.style.decimal_comma;
  layout.format = layout.separator == ',' || layout.separator == ';' ? "CSV" : "text";
  layout.num_columns = guess.num_columns;
  size_columns(layout);
  std::vector<std::string_view> remark;
  for (const auto& line : lines) {
    const auto text = trimmed(line.text);
    if (text.empty()) continue;
    if (is_comment(text)) {
      remark = fields_of(trimmed(text.substr(1)), layout.separator);
      continue;
    }
    if (is_row(line.text, layout.separator, layout.decimal_comma)) {
      layout.data_offset = line.offset;
      layout.first_line = line.number;
      break;
    }
    const auto fields = fields_of(line.text, layout.separator);
    const bool fits = static_cast<int>(fields.size()) == layout.num_columns;
    if (layout.named && fits && set_units(layout, fields)) continue;
    if (layout.named) throw fault(line, fmt::format("want numbers under the header, got {}", file.quoted(text)));
    if (!fits)
      throw fault(line,
                  fmt::format("the header names {} columns, the rows have {}", fields.size(), layout.num_columns));
    set_names(layout, fields);
  }
  // Names may be in the last comment above the numbers.
  if (!layout.named && static_cast<int>(remark.size()) == layout.num_columns) set_names(layout, remark);
  find_moments(layout, lines);
  if (layout.time_column < 0 && !layout.named) find_clock_like(layout, lines);
  return layout;
}

// ---- LabVIEW text (LVM): two headers of `key<separator>value...`, a line of names, rows.

constexpr std::string_view lvm_end = "***End_of_Header***";

std::optional<double> lvm_rate(std::string_view step_text, bool decimal_comma) {
  double step_s = 0;
  if (parse_cell(step_text, decimal_comma, step_s) != Cell::number || !(step_s > 0)) return std::nullopt;
  return roundest_rate(1 / step_s, 0.5 * last_digit(unquoted(step_text)) / step_s);
}

TableLayout lvm_layout(const InputFile& file, const std::vector<Line>& lines) {
  TableLayout layout;
  layout.format = "LabVIEW";
  layout.separator = '\t';
  layout.comments_behind = true;
  std::string x_columns = "One";
  std::vector<std::string_view> samples, units, steps;
  int ends = 0;
  for (const auto& line : lines) {
    const auto text = trimmed(line.text);
    if (line.number == 1) layout.separator = line.text.find(',') != std::string::npos ? ',' : '\t';
    auto fields = fields_of(line.text, layout.separator);
    const std::string_view key = fields.empty() ? std::string_view() : trimmed(fields[0]);
    const std::string_view value = fields.size() > 1 ? trimmed(fields[1]) : std::string_view();
    if (key == "Decimal_Separator") layout.decimal_comma = value == ",";
    if (key == "X_Columns") x_columns = value;
    if (key == "Samples") samples = fields;
    if (key == "Y_Unit_Label") units = fields;
    if (key == "Delta_X") steps = fields;
    if (key == lvm_end) ++ends;
    if (ends < 2 || key == lvm_end || text.empty()) continue;
    if (layout.named) {  // the first row
      layout.data_offset = line.offset;
      layout.first_line = line.number;
      break;
    }
    if (!fields.empty() && trimmed(fields.back()) == "Comment") fields.pop_back();
    layout.num_columns = static_cast<int>(fields.size());
    size_columns(layout);
    set_names(layout, fields);
    long most = 0;
    std::vector<long> counts(layout.columns.size(), 0);
    for (std::size_t i = 1; i < layout.columns.size(); ++i) {  // a column's entries are above it, blank over its own X
      if (i < units.size() && is_unit(trimmed(units[i]))) layout.units[i] = find_unit(units[i]).name;
      if (i < samples.size()) {
        const auto count = trimmed(samples[i]);
        std::from_chars(count.data(), count.data() + count.size(), counts[i]);
        most = std::max(most, counts[i]);
      }
    }
    for (std::size_t i = 1; i < layout.columns.size(); ++i)
      layout.partial[i] = layout.columns[i] == "X_Value" || counts[i] < most;
  }
  if (layout.num_columns == 0 || layout.data_offset == 0)
    throw Fault(FaultKind::input, "table.header",
                fmt::format("{}: a LabVIEW header without {} under it", file.name(),
                            layout.named && layout.num_columns == 0 ? "columns" : "rows"));
  if (x_columns != "No") layout.time_column = 0;
  layout.partial[0] = x_columns == "No";  // empty then
  if (steps.size() > 1) layout.rate_hz = lvm_rate(steps[1], layout.decimal_comma);
  return layout;
}

}  // namespace

double roundest_rate(double rate_hz, double relative) {
  const double low = rate_hz * (1 - relative), high = rate_hz * (1 + relative);
  for (double unit = 1e9; unit >= 1; unit /= 10) {
    const double whole = std::round(rate_hz / unit) * unit;
    if (whole >= low && whole <= high && whole > 0) return whole;
  }
  for (int denominator = 2; denominator <= 1000; ++denominator) {
    const double numerator = std::round(rate_hz * denominator);
    const double rate = numerator / denominator;
    if (rate >= low && rate <= high && rate > 0) return rate;
  }
  return rate_hz;
}

TableLayout table_layout(const InputFile& file) {
  constexpr std::size_t looked_at = 100;
  const auto lines = first_lines(file, looked_at);
  if (!lines.empty() && lines[0].text.starts_with("LabVIEW Measurement")) return lvm_layout(file, lines);
  return csv_layout(file, lines);
}

}  // namespace dsp
