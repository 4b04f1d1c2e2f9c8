#include "dsp/io/table_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "dsp/io/foreign_file.hpp"
#include "dsp/io/labview_layout.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/io/table_columns.hpp"
#include "dsp/io/table_header.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

// First words of lines that sum a column up.
constexpr std::array summaries{"mean", "average", "std",        "stdev",        "min",     "minimum", "max",  "maximum",
                               "rms",  "sum",     "mittelwert", "standardabw.", "moyenne", "media",   "count"};

bool begins_summary(std::string_view cell) {
  const std::string word = lower(unquoted(cell));
  return std::find(summaries.begin(), summaries.end(), word) != summaries.end();
}

bool has_no_digit(std::string_view line) {
  return line.find_first_of("0123456789") == line.npos;
}

// Where rows end: before lines that are none and come behind a blank line, begin as a summary does or hold words alone,
// and before rows of empty cells, as spreadsheets write them.
void find_end(TableLayout& layout, const InputFile& file) {
  constexpr std::uint64_t looked_at = std::uint64_t{1} << 14;
  layout.end_offset = file.size();
  const auto from = std::max(layout.data_offset, file.size() - std::min(file.size(), looked_at));
  const std::string text = file.text(from, static_cast<std::size_t>(file.size() - from));
  std::size_t at = from == layout.data_offset ? 0 : std::min(text.find('\n'), text.size() - 1) + 1;
  std::uint64_t end = 0;  // behind the last row
  bool is_apart = false;
  std::size_t behind = 0, num_blank = 0;  // lines
  std::string first;
  for (; at < text.size();) {
    const auto line_end = std::min(text.find('\n', at), text.size());
    std::string_view whole = std::string_view(text).substr(at, line_end - at);
    if (whole.ends_with('\r')) whole.remove_suffix(1);
    const std::string_view line = trimmed(whole);
    at = line_end + 1;
    if (line.find_first_not_of(std::string{layout.style.separator, ' ', '"'}) ==
        line.npos) {  // blank, or cells that are
      is_apart = is_apart || behind == 0;
      num_blank += behind == 0 && !line.empty() ? 1 : 0;
    } else if (line.front() == '#' || line.front() == '%') {
      continue;
    } else if (layout.style.is_row(whole)) {
      end = from + at;
      is_apart = false;
      behind = 0;
      num_blank = 0;
    } else if (end > 0) {
      if (behind++ == 0) {
        first = line;
        is_apart = is_apart || begins_summary(layout.style.cells(line).front()) || has_no_digit(line);
      }
    }
  }
  if (end == 0 || (behind > 0 && !is_apart) || (behind == 0 && num_blank == 0)) return;
  layout.end_offset = end;
  if (behind == 0) return;
  layout.checks.push_back(
      {"table.end", "", CheckStatus::warning, static_cast<double>(behind), 0.0,
       fmt::format("{}: what is under the rows ({}) is no row of numbers and was left out, from {} "
                   "on. Delete it if it is no part of the record",
                   file.name(), behind == 1 ? "one line" : fmt::format("{} lines", behind), file.quoted(first))});
}

void note_skipped(TableLayout& layout, const TableHeader& header, const InputFile& file) {
  if (header.skipped.empty()) return;
  layout.checks.push_back(
      {"table.skipped", "", CheckStatus::note, static_cast<double>(header.skipped.size()), 0.0,
       fmt::format("{}: skipped {} above the table, the last is line {}: {}", file.name(),
                   header.skipped.size() == 1 ? "one line" : fmt::format("{} lines", header.skipped.size()),
                   header.skipped.back()->number, file.quoted(header.skipped.back()->text))});
}

// "1,234" beside "987" and "12,345,678" in one column read with decimal commas: thousands are marked, and 1.234 would
// be as wrong as it is silent. A decimal comma behind which there are always three digits has "0,987".
void refuse_thousands(const InputFile& file, const std::vector<TableLine>& lines, const TableLayout& layout) {
  if (!layout.style.decimal_comma) return;
  for (std::size_t c = 0; c < layout.columns.size(); ++c) {
    std::string_view grouped, plain;
    bool may_be = true;
    for (const TableLine& line : lines) {
      if (line.number < layout.first_line || line.is_comment() || !layout.style.is_row(line.text)) continue;
      const auto cells = layout.style.cells(line.text);
      auto cell = c < cells.size() ? unquoted(cells[c]) : std::string_view();
      while (cell.starts_with('-') || cell.starts_with('+')) cell.remove_prefix(1);
      const auto comma = cell.find(',');
      constexpr std::size_t group = 3;
      if (comma == cell.npos)
        plain = cell.size() <= group && cell.size() > 1 ? cell : plain, may_be = may_be && cell.size() <= group;
      else
        grouped = cell, may_be = may_be && cell.front() != '0' && comma <= group && cell.size() == comma + 1 + group;
    }
    if (may_be && !grouped.empty() && !plain.empty())
      throw Fault(FaultKind::input, "table.thousands",
                  fmt::format("{}: column {} marks thousands with commas ({} beside {}), which are decimal commas "
                              "elsewhere. Write it without them: tr -d , < '{}' > '{}.plain'",
                              file.name(), c + 1, file.quoted(grouped), file.quoted(plain), path_to_paste(file),
                              path_to_paste(file)));
  }
}

Fault misfit(const InputFile& file, const TableLine& line, const TableStyle& style, bool is_stated) {
  const auto named = style.cells(line.text).size();
  if (style.separator == ',' && 2 * named == static_cast<std::size_t>(style.num_columns))
    return Fault(
        FaultKind::input, "table.header",
        fmt::format("{}:{}: the header names {} columns, the rows have {}: commas are both between cells and in "
                    "numbers. Write points into these: sed -E 's/([0-9]+),([0-9]+)/\\1.\\2/g' '{}' > '{}.plain'",
                    file.name(), line.number, named, style.num_columns, path_to_paste(file), path_to_paste(file)));
  const std::string remedy =
      is_stated ? "Correct header_row"
                : fmt::format("To do without it, put at the top of {}:", sidecar_path(file.name()).string());
  return Fault(FaultKind::input, "table.header",
               fmt::format("{}:{}: the header names {} columns, the rows have {}. {}", file.name(), line.number,
                           style.cells(line.text).size(), style.num_columns, remedy),
               is_stated ? "" : fmt::format("skip_rows = {}\n", line.number));
}

// "0,1,2" over rows whose every number has a decimal mark: a spreadsheet's columns, numbered.
bool is_numbering(const TableLine& line, const TableLine& next, const TableStyle& style) {
  const auto cells = style.cells(line.text), values = style.cells(next.text);
  if (cells.size() < 2 || cells.size() != values.size() || !style.is_row(next.text)) return false;
  const char mark = style.decimal_comma ? ',' : '.';
  const std::size_t from = unquoted(cells.front()) == "0" ? 0 : 1;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (unquoted(cells[i]) != std::to_string(from + i) || values[i].find(mark) == std::string_view::npos) return false;
  return true;
}

TableLayout plain_layout(const InputFile& file, const std::vector<TableLine>& lines, const OpenOptions& options) {
  TableLayout layout;
  layout.style = table_style(lines);
  if (layout.style.num_columns == 0)
    throw Fault(FaultKind::input, "container.unknown",
                fmt::format("{}: text, but no line of its first {} is a row of numbers{}. Read are {}", file.name(),
                            lines.size(), why_no_row(file, lines), readable_formats));
  const char separator = layout.style.separator;
  layout.format = separator == ',' || separator == ';' ? "CSV" : "text";
  layout.columns.resize(static_cast<std::size_t>(layout.style.num_columns));
  auto first = std::find_if(lines.begin(), lines.end(), [&](const TableLine& line) {
    return line.number > options.header_row && !line.is_comment() && layout.style.is_row(line.text);
  });
  if (first == lines.end())
    throw Fault(FaultKind::input, "table.header",
                fmt::format("{}: no rows behind header_row = {}", file.name(), options.header_row));
  if (first + 1 != lines.end() && is_numbering(*first, *(first + 1), layout.style)) ++first;
  layout.data_offset = first->offset;
  layout.first_line = first->number;
  const std::vector<TableLine> above(lines.begin(), first);
  const TableHeader header = table_header(above, layout.style, options.header_row);
  if (header.misfit != nullptr) throw misfit(file, *header.misfit, layout.style, options.header_row > 0);
  if (!header.names.empty()) set_names(layout, header.names);
  for (const TableLine& line : above)
    if (!header.names.empty() && line.text.data() <= header.names.front().data() &&
        header.names.front().data() < line.text.data() + line.text.size())
      layout.names_line = trimmed(line.text);
  for (std::size_t i = 0; i < header.units.size(); ++i)
    if (!header.units[i].empty()) layout.columns[i].unit = header.units[i];
  layout.rate_hz = header.rate_hz;
  note_skipped(layout, header, file);
  refuse_thousands(file, lines, layout);
  find_contents(layout, lines, file, options);
  find_end(layout, file);
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

TableLayout table_layout(const InputFile& file, const OpenOptions& options) {
  constexpr std::size_t looked_at = 250;  // loggers write up to 200 lines of settings above their rows
  const auto lines = first_lines(file, looked_at, options.skip_rows);
  TableLayout layout = is_labview(lines) ? labview_layout(file, lines) : plain_layout(file, lines, options);
  note_left_out(layout, file);
  return layout;
}

}  // namespace dsp
