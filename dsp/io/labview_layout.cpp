#include "dsp/io/labview_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "dsp/io/table_columns.hpp"
#include "dsp/io/units.hpp"

namespace dsp {
namespace {

constexpr std::string_view end_of_header = "***End_of_Header***", first_of_segment = "Channels";

std::optional<double> rate_of(std::string_view step_text, bool decimal_comma) {
  double step_s = 0;
  if (parse_cell(step_text, decimal_comma, step_s) != Cell::number || !(step_s > 0)) return std::nullopt;
  return roundest_rate(1 / step_s, 0.5 * last_digit(unquoted(step_text)) / step_s);
}

/// What the headers say, entry by entry; those of channels have a cell a column, blank over a channel's own X.
struct Header {
  std::string x_columns = "One";
  bool repeats = false;
  std::vector<std::string_view> samples, units, steps;
};

std::vector<long> counts_of(const Header& header, std::size_t num_columns) {
  std::vector<long> counts(num_columns, 0);
  for (std::size_t i = 1; i < std::min(num_columns, header.samples.size()); ++i) {
    const auto text = trimmed(header.samples[i]);
    std::from_chars(text.data(), text.data() + text.size(), counts[i]);
  }
  return counts;
}

void describe(TableLayout& layout, const Header& header) {
  const std::vector<long> counts = counts_of(header, layout.columns.size());
  const long most = counts.empty() ? 0 : *std::max_element(counts.begin(), counts.end());
  for (std::size_t i = 1; i < layout.columns.size(); ++i) {
    TableColumn& column = layout.columns[i];
    if (i < header.units.size() && is_unit(trimmed(header.units[i]))) column.unit = find_unit(header.units[i]).name;
    if (column.name == "X_Value")
      column.left_out = "another time column";
    else if (counts[i] < most)
      column.left_out = fmt::format("{} samples, others have {}", counts[i], most);
  }
  if (header.x_columns != "No")
    layout.time_column = 0;
  else
    layout.columns[0].left_out = "empty";
  if (header.steps.size() > 1) layout.rate_hz = rate_of(header.steps[1], layout.style.decimal_comma);
}

}  // namespace

bool is_labview(const std::vector<TableLine>& lines) {
  return !lines.empty() && lines[0].text.starts_with("LabVIEW Measurement");
}

TableLayout labview_layout(const InputFile& file, const std::vector<TableLine>& lines) {
  TableLayout layout;
  layout.format = "LabVIEW";
  layout.comments_behind = true;
  layout.end_offset = file.size();
  TableStyle& style = layout.style;
  style.separator = lines[0].text.find(',') != std::string::npos ? ',' : '\t';
  Header header;
  int ends = 0;
  for (const TableLine& line : lines) {
    auto cells = style.cells(line.text);
    const std::string_view key = cells.empty() ? std::string_view() : trimmed(cells[0]);
    const std::string_view value = cells.size() > 1 ? trimmed(cells[1]) : std::string_view();
    if (key == "Decimal_Separator") style.decimal_comma = value == ",";
    if (key == "X_Columns") header.x_columns = value;
    if (key == "Multi_Headings") header.repeats = value == "Yes";
    if (key == "Samples") header.samples = cells;
    if (key == "Y_Unit_Label") header.units = cells;
    if (key == "Delta_X") header.steps = cells;
    if (key == end_of_header) ++ends;
    if (ends < 2 || key == end_of_header || line.is_blank()) continue;
    if (layout.named) {  // the first row
      layout.data_offset = line.offset;
      layout.first_line = line.number;
      break;
    }
    if (!cells.empty() && trimmed(cells.back()) == "Comment") cells.pop_back();
    style.num_columns = static_cast<int>(cells.size());
    style.is_text.resize(cells.size());
    layout.columns.resize(cells.size());
    set_names(layout, cells);
  }
  if (style.num_columns == 0 || layout.data_offset == 0)
    throw Fault(FaultKind::input, "table.header",
                fmt::format("{}: a LabVIEW header without {} under it", file.name(),
                            layout.named && style.num_columns == 0 ? "columns" : "rows"));
  describe(layout, header);
  if (header.repeats) layout.header_again = first_of_segment, layout.header_end = end_of_header;
  return layout;
}

}  // namespace dsp
