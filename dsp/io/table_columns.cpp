#include "dsp/io/table_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "dsp/io/channel_roles.hpp"
#include "dsp/io/found_clock.hpp"
#include "dsp/io/moment.hpp"
#include "dsp/io/sidecar.hpp"
#include "dsp/io/units.hpp"
#include "dsp/values/names.hpp"
#include "dsp/values/order_statistics.hpp"

namespace dsp {
namespace {

std::string base_of(const TableColumn& column) {
  return split_unit(column.name).base;
}

bool may_be_time(const TableColumn& column) {
  return column.unit.empty() || find_unit(column.unit).si == "s";
}

/// What the first rows have in one column.
struct Beginning {
  std::vector<double> values;  // NaN where it is none
  bool has_text = false, has_moments = false, has_time_of_day = false;
  std::size_t num_values = 0;
};

std::vector<Beginning> beginnings(TableLayout& layout, const std::vector<TableLine>& lines) {
  std::vector<Beginning> found(layout.columns.size());
  for (const TableLine& line : lines) {
    if (line.number < layout.first_line || line.is_comment() || !layout.style.is_row(line.text)) continue;
    auto cells = layout.style.cells(line.text);
    cells.resize(found.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      Beginning& column = found[i];
      const Cell cell = parse_cell(cells[i], layout.style.decimal_comma, column.values.emplace_back());
      if (cell == Cell::number) ++column.num_values;
      if (cell != Cell::bad) continue;
      const auto moment = parse_moment(cells[i]);
      if (moment && !moment->has_time() && !layout.first_day) layout.first_day = moment->day;
      column.has_moments = column.has_moments || moment;
      column.has_time_of_day = column.has_time_of_day || (moment && moment->has_time());
      column.has_text = column.has_text || !moment;
    }
  }
  return found;
}

bool counts_rows(const std::vector<double>& values) {
  constexpr std::size_t fewest = 8;  // fewer rise by ones by chance
  if (values.size() < fewest) return false;
  const auto steps = steps_of(values);
  const auto ones = std::count(steps.begin(), steps.end(), 1.0);
  constexpr double usual = 0.9;  // where rows are lost the count goes on
  return static_cast<double>(ones) >= usual * static_cast<double>(steps.size()) &&
         std::all_of(steps.begin(), steps.end(), [](double step) { return step >= 1.0 && step == std::floor(step); });
}

// "Run 2: Position" without "Run 2:".
std::string_view without_run_before(std::string_view name) {
  for (const std::string_view word : {"run", "trial", "test", "set", "data set", "messung", "lauf", "versuch"}) {
    if (!lower(name).starts_with(word)) continue;
    const auto number = name.find_first_not_of(" #_", word.size());
    const auto end = std::min(name.find_first_not_of("0123456789", std::min(number, name.size())), name.size());
    const auto stem = std::min(name.find_first_not_of(" :_-.", end), name.size());
    if (number != name.npos && end > number && stem > end && stem < name.size()) return name.substr(stem);
  }
  return name;
}

// The name without the run at its end or before it: "Time Run #2", "angle_2", "Run 2: Time".
std::string without_run(std::string_view whole) {
  const std::string_view name = without_run_before(whole);
  std::string_view stem = name;
  while (!stem.empty() && stem.back() >= '0' && stem.back() <= '9') stem.remove_suffix(1);
  if (stem.size() == name.size()) return std::string(name);
  while (!stem.empty() && (stem.back() == '#' || stem.back() == '_' || stem.back() == ' ')) stem.remove_suffix(1);
  for (const std::string_view word : {" Run", " run", "_run", "_Run"})
    if (stem.ends_with(word)) stem.remove_suffix(word.size());
  return stem.empty() ? std::string(name) : std::string(stem);
}

// How many columns a run has, where the same ones with a clock each stand side by side; 0: there are no runs.
std::size_t columns_of_run(const std::vector<std::string>& stems, const TableLayout& layout) {
  std::size_t clocks = 0;
  for (std::size_t i = 0; i < stems.size(); ++i)
    clocks += may_be_time(layout.columns[i]) && speaks_of_time(stems[i]) ? 1 : 0;
  if (clocks < 2 || stems.size() % clocks != 0) return 0;
  const std::size_t width = stems.size() / clocks;
  for (std::size_t i = width; i < stems.size(); ++i)
    if (stems[i] != stems[i - width]) return 0;
  return width > 1 ? width : 0;
}

std::string run_lines(std::size_t runs, const std::vector<std::string>& stems, std::size_t width,
                      const InputFile& file) {
  std::vector<std::string> columns;
  for (std::size_t i = 0; i < width; ++i) columns.push_back(file.quoted(stems[i]));
  std::string lines;
  for (std::size_t run = 1; run <= runs; ++run)
    lines += fmt::format("{}run = {}  # columns {} to {}: {}\n", run > 1 ? "# " : "", run, (run - 1) * width + 1,
                         run * width, fmt::join(columns, ", "));
  return lines + "# run = \"all\"  # each of them a recording\n";
}

void choose_run(TableLayout& layout, const InputFile& file, const OpenOptions& options) {
  std::vector<std::string> stems;
  for (const TableColumn& column : layout.columns) stems.push_back(without_run(base_of(column)));
  const std::size_t width = layout.named ? columns_of_run(stems, layout) : 0;
  if (width == 0 && options.run <= 1) return;
  const std::size_t runs = width == 0 ? 1 : stems.size() / width;
  if (options.run > static_cast<int>(runs))
    throw Fault(FaultKind::usage, "channel.index",
                fmt::format("{}: got run = {}, but it holds {} side by side", file.name(), options.run,
                            runs == 1 ? "no several runs" : fmt::format("{} runs", runs)));
  if (options.run == 0 && options.with_clock && options.time_column.empty())
    throw Fault(FaultKind::input, "clock.run",
                fmt::format("{}: holds {} runs side by side, each with a clock of its own. Choose one at the top of "
                            "{}:",
                            file.name(), runs, sidecar_path(file.name()).string()),
                run_lines(runs, stems, width, file));
  layout.num_runs = static_cast<int>(runs);
  layout.is_one_run = true;
  const std::size_t chosen = static_cast<std::size_t>(std::max(options.run, 1));
  for (std::size_t i = 0; width > 0 && i < stems.size(); ++i) {
    const std::size_t run = i / width + 1;
    layout.columns[i].name = run == chosen ? stems[i] : fmt::format("{} run {}", stems[i], run);
    if (run != chosen) layout.columns[i].left_out = fmt::format("run {}", run);
  }
}

// "Time (min)": a clock, but of what is not known.
bool is_in_unknown_unit(const std::string& base) {
  return base.find_first_of("([") != std::string::npos && speaks_of_time(base) && unit_of_time_name(base).empty();
}

// "t_fast", "t2": beside others of its kind a clock.
bool is_numbered_time(std::string_view base) {
  return base.size() > 1 && (base.front() == 't' || base.front() == 'T') &&
         (base[1] == '_' || base[1] == ' ' || base.find_first_not_of("0123456789", 1) == base.npos);
}

// The usual step of a clock in seconds, as far as its first rows and its unit tell; 0 where they do not.
double step_s_of(const TableColumn& column, const Beginning& first) {
  std::vector<double> known = first.values;
  std::erase_if(known, [](double value) { return !std::isfinite(value); });
  const std::string unit = column.unit.empty() ? unit_of_time_name(base_of(column)) : column.unit;
  return is_clock_like(known) ? median(steps_of(known)) * (unit.empty() ? 1.0 : find_unit(unit).factor) : 0.0;
}

bool may_be_clock(const TableColumn& column) {
  const std::string base = base_of(column);
  return column.left_out.empty() && may_be_time(column) && !column.holds_moments && !column.holds_text &&
         (speaks_of_time(base) || is_numbered_time(base));
}

// Without the second of rows that a recorder wrote twice, where they are few.
std::vector<double> without_repeats(const std::vector<double>& values) {
  constexpr double most = 0.1;
  std::vector<double> kept = values;
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  return static_cast<double>(kept.size()) > (1.0 - most) * static_cast<double>(values.size()) ? kept : values;
}

// Of several clocks in one table the fastest; the signals behind a slower one, up to the next clock, are on that.
void leave_out_slower_clocks(TableLayout& layout, const std::vector<Beginning>& first) {
  std::vector<std::size_t> clocks;
  std::vector<double> steps_s;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const double step_s = may_be_clock(layout.columns[i]) ? step_s_of(layout.columns[i], first[i]) : 0.0;
    if (step_s <= 0.0) continue;
    clocks.push_back(i);
    steps_s.push_back(step_s);
  }
  if (clocks.size() < 2 || clocks.front() != 0 || clocks.back() + 1 == first.size()) return;
  for (std::size_t k = 1; k < clocks.size(); ++k)
    if (clocks[k] == clocks[k - 1] + 1) return;  // two ways to write one clock
  constexpr double same = 0.05;
  const double fastest_s = *std::min_element(steps_s.begin(), steps_s.end());
  if (*std::max_element(steps_s.begin(), steps_s.end()) <= (1.0 + same) * fastest_s) return;
  int chosen = -1;
  for (std::size_t k = 0; k < clocks.size(); ++k) {
    const bool is_fastest = steps_s[k] <= (1.0 + same) * fastest_s;
    if (is_fastest && chosen < 0) chosen = static_cast<int>(clocks[k]);
    const std::size_t end = k + 1 < clocks.size() ? clocks[k + 1] : first.size();
    for (std::size_t i = clocks[k]; i < end && !is_fastest; ++i)
      layout.columns[i].left_out =
          i == clocks[k] ? fmt::format("the clock of the columns behind it, {:.4g} Hz", 1.0 / steps_s[k])
                         : fmt::format("its clock is column {}, {:.4g} Hz", clocks[k] + 1, 1.0 / steps_s[k]);
  }
  layout.time_column = chosen;
  layout.is_one_run = true;
}

// A number called time; else one that speaks of time and rises evenly; else a column of times of day.
void find_time(TableLayout& layout, const std::vector<Beginning>& first) {
  std::vector<int> by_name, by_word, by_moment;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const TableColumn& column = layout.columns[i];
    const std::string base = base_of(column);
    if (!column.left_out.empty() || !may_be_time(column)) continue;
    if (first[i].has_time_of_day) by_moment.push_back(static_cast<int>(i));
    if (column.holds_moments || column.holds_text) continue;
    if (is_time_name(base)) by_name.push_back(static_cast<int>(i));
    if (speaks_of_time(base) && !is_in_unknown_unit(base) && is_clock_like(without_repeats(first[i].values)))
      by_word.push_back(static_cast<int>(i));
  }
  leave_out_slower_clocks(layout, first);
  for (const auto* found : {&by_name, &by_word, &by_moment})
    if (layout.time_column < 0 && !found->empty()) layout.time_column = found->front();
  if (layout.time_column < 0) return;
  layout.columns[static_cast<std::size_t>(layout.time_column)].left_out.clear();
  TableColumn& clock = layout.columns[static_cast<std::size_t>(layout.time_column)];
  if (clock.unit.empty()) clock.unit = unit_of_time_name(base_of(clock));
}

// The only column that could be a clock, as far as its first rows tell: without a name or one that says nothing.
void find_clock_like(TableLayout& layout, const std::vector<Beginning>& first,
                     const std::vector<std::string>& signals) {
  std::vector<int> found;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const TableColumn& column = layout.columns[i];
    const auto is = [&](const std::string& one) {
      return one == std::to_string(i + 1) || (!one.empty() && (one == column.name || one == base_of(column)));
    };
    if (!column.left_out.empty() || !may_be_time(column) || names_signal(base_of(column)) ||
        is_in_unknown_unit(base_of(column)) || std::any_of(signals.begin(), signals.end(), is))
      continue;
    if (is_clock_like(first[i].values)) found.push_back(static_cast<int>(i));
  }
  if (found.size() == 1) layout.clock_like_column = found.front();  // of two, a person must say which
}

// Why a column is no channel.
std::string why_left_out(const TableColumn& column, const Beginning& first) {
  if (column.holds_text) return "text";
  if (column.holds_moments) return "dates and times";
  if (column.counts_rows && !names_signal(base_of(column))) return "counts rows";
  if (may_be_time(column) && speaks_of_time(base_of(column)) && is_clock_like(first.values))
    return "another time column";
  const auto both = [](double value, double next) { return std::isfinite(value) && std::isfinite(next); };
  const bool is_slower =
      first.num_values > 2 && std::adjacent_find(first.values.begin(), first.values.end(), both) == first.values.end();
  if (is_slower && 2 * first.num_values <= first.values.size() + 1)
    return fmt::format("values in {} of the first {} rows", first.num_values, first.values.size());
  return "";
}

// Whether values end so early in the first rows that they are none of a channel.
bool ends_early(const Beginning& first) {
  constexpr std::size_t few = 10;  // times fewer than rows
  const auto is_value = [](double value) { return std::isfinite(value); };
  const auto from_last = std::find_if(first.values.rbegin(), first.values.rend(), is_value) - first.values.rbegin();
  return few * (first.values.size() - static_cast<std::size_t>(from_last)) < first.values.size();
}

// Columns without a value in the first rows or with few at their beginning, and none behind wherever it was looked.
void leave_out_empty(TableLayout& layout, const std::vector<Beginning>& first, const InputFile& file) {
  constexpr std::uint64_t looked_at = std::uint64_t{1} << 14, num_places = 8;
  const auto is_open = [&](std::size_t i) {
    const TableColumn& column = layout.columns[i];
    return ends_early(first[i]) && column.left_out.empty() && static_cast<int>(i) != layout.time_column;
  };
  std::vector<bool> is_empty(first.size());
  bool has_channel = false;  // or the record is empty, which is another matter
  for (std::size_t i = 0; i < first.size(); ++i) {
    is_empty[i] = is_open(i);
    has_channel = has_channel ||
                  (!is_empty[i] && layout.columns[i].left_out.empty() && static_cast<int>(i) != layout.time_column);
  }
  if (!has_channel || std::find(is_empty.begin(), is_empty.end(), true) == is_empty.end()) return;
  const std::uint64_t length = file.size() - std::min<std::uint64_t>(file.size(), layout.data_offset);
  for (std::uint64_t place = 1; place <= num_places; ++place) {
    const auto end_of_place = layout.data_offset + length * place / num_places;
    const auto from = std::max<std::uint64_t>(layout.data_offset, end_of_place - std::min(end_of_place, looked_at));
    const std::string text = file.text(from, static_cast<std::size_t>(end_of_place - from));
    for (std::size_t at = std::min(text.find('\n'), text.size() - 1) + 1; at < text.size();) {
      const auto end = text.find('\n', at);
      if (end == std::string::npos && place < num_places) break;  // a part of a row
      const auto cells = layout.style.cells(std::string_view(text).substr(at, std::min(end, text.size()) - at));
      double value = 0.0;
      for (std::size_t i = 0; i < std::min(cells.size(), is_empty.size()); ++i)
        if (parse_cell(cells[i], layout.style.decimal_comma, value) != Cell::missing) is_empty[i] = false;
      at = std::min(end, text.size()) + 1;
    }
  }
  for (std::size_t i = 0; i < first.size(); ++i)
    if (is_empty[i])
      layout.columns[i].left_out = first[i].num_values == 0 ? "no values"
                                                            : fmt::format("values in {} of the first {} rows",
                                                                          first[i].num_values, first[i].values.size());
}

}  // namespace

void set_names(TableLayout& layout, const std::vector<std::string_view>& names) {
  layout.named = true;
  for (std::size_t i = 0; i < layout.columns.size(); ++i) {
    layout.columns[i].name = clean_name(unquoted(names[i]));
    layout.columns[i].unit = split_unit(layout.columns[i].name).unit;
  }
}

void find_contents(TableLayout& layout, const std::vector<TableLine>& lines, const InputFile& file,
                   const OpenOptions& options) {
  choose_run(layout, file, options);
  const std::vector<Beginning> first = beginnings(layout, lines);
  for (std::size_t i = 0; i < first.size(); ++i) {
    TableColumn& column = layout.columns[i];
    column.holds_moments = first[i].has_moments;
    column.holds_text = first[i].has_text;
    column.counts_rows = counts_rows(first[i].values);
    if (column.holds_moments) column.unit.assign(1, 's');  // GCC 12 warns of = "s"
  }
  find_time(layout, first);
  if (layout.time_column < 0) find_clock_like(layout, first, options.signal_columns);
  for (std::size_t i = 0; i < first.size(); ++i) {
    TableColumn& column = layout.columns[i];
    if (column.left_out.empty() && static_cast<int>(i) != layout.time_column)
      column.left_out = why_left_out(column, first[i]);
  }
  leave_out_empty(layout, first, file);
}

void note_left_out(TableLayout& layout, const InputFile& file) {
  std::vector<std::string> named;
  for (std::size_t i = 0; i < layout.columns.size(); ++i) {
    const TableColumn& column = layout.columns[i];
    if (column.left_out.empty() || is_time_name(column.name) || static_cast<int>(i) == layout.time_column) continue;
    named.push_back(fmt::format("{} ({})", layout.named ? file.quoted(column.name) : fmt::format("column {}", i + 1),
                                column.left_out));
  }
  if (named.empty()) return;
  constexpr std::size_t most_named = 20;
  const std::size_t count = named.size();
  if (count > most_named) named.resize(most_named);
  layout.checks.push_back({"table.left_out", "", CheckStatus::note, static_cast<double>(count), 0.0,
                           fmt::format("{}: not used as signals: {}{}", file.name(), fmt::join(named, ", "),
                                       count > most_named ? fmt::format(" and {} more", count - most_named) : "")});
}

}  // namespace dsp
