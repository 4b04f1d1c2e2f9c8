#include "dsp/io/table_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>

#include "dsp/io/foreign_file.hpp"
#include "dsp/io/found_clock.hpp"
#include "dsp/io/moment.hpp"
#include "dsp/io/rows_on_clock.hpp"
#include "dsp/io/table_layout.hpp"
#include "dsp/io/text_lines.hpp"
#include "dsp/io/units.hpp"
#include "dsp/values/memory_limit.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

/// The lines of a table that are rows: neither blank, nor remarks, nor of a header between rows, nor behind the last.
class RowLines {
 public:
  RowLines(const InputFile& file, const TableLayout& layout)
      : lines_(file, layout.data_offset, layout.first_line), layout_(&layout) {}

  bool next(std::string_view& line) {
    for (int in_header = 0; lines_.next(line) && lines_.offset() < layout_->end_offset;) {
      const auto text = trimmed(line);
      if (in_header == 2 || text.empty() || text.front() == '#' || text.front() == '%') {
        in_header = in_header == 2 ? 0 : in_header;  // the line of names ends a header
      } else if (in_header == 0 && text == layout_->names_line) {
        ++num_headers_;
      } else if (in_header == 1) {
        in_header = text.starts_with(layout_->header_end) ? 2 : 1;
      } else if (!layout_->header_again.empty() && text.starts_with(layout_->header_again)) {
        in_header = 1;
      } else {
        return true;
      }
    }
    return false;
  }
  [[nodiscard]] std::int64_t number() const { return lines_.number(); }
  [[nodiscard]] bool ended() const { return lines_.ended(); }
  [[nodiscard]] std::int64_t num_headers() const { return num_headers_; }  ///< lines of names between the rows so far

 private:
  std::int64_t num_headers_ = 0;
  TextLines lines_;
  const TableLayout* layout_;
};

/// To what digit numbers are printed: so many places behind the point, or so many figures, so that large ones are
/// coarser.
class PrintedDigits {
 public:
  void note(double value, double digit) {
    const double size = std::abs(value);
    if (current_ == nullptr || size < from_ || size >= 10.0 * from_) {
      const int exponent = size > 0.0 ? static_cast<int>(std::floor(std::log10(size))) : least_exponent;
      from_ = std::pow(10.0, exponent);
      current_ = &decades_[exponent];
    }
    // The finest digit counts: some writers leave zeros at the end away.
    current_->digit = current_->count++ == 0 ? digit : std::min(current_->digit, digit);
    finest_ = std::min(finest_, digit);
  }
  /// The finest digit of the decade that is printed most coarsely; 0 without numbers.
  [[nodiscard]] double coarsest() const {
    constexpr std::int64_t enough = 10;  // that all should end in a zero by chance
    double coarsest = 0.0;
    for (const auto& [exponent, decade] : decades_)
      if (decade.count >= enough) coarsest = std::max(coarsest, decade.digit);
    return coarsest > 0.0 ? coarsest : decades_.empty() ? 0.0 : finest_;
  }

 private:
  static constexpr int least_exponent = -400;
  struct Decade {
    double digit = 0.0;
    std::int64_t count = 0;
  };
  std::map<int, Decade> decades_;
  Decade* current_ = nullptr;
  double from_ = 0.0, finest_ = std::numeric_limits<double>::infinity();
};

/// Rows with the time of the row before.
struct Repeats {
  std::vector<std::int64_t> rows;
  bool are_whole_rows = true;  // each is the row before, letter by letter
  std::string before;

  void look_at(const std::vector<double>& time_s, std::string_view line) {
    const auto count = time_s.size();
    if (count > 1 && time_s[count - 1] == time_s[count - 2]) {
      are_whole_rows = are_whole_rows && line == before;
      if (are_whole_rows) rows.push_back(static_cast<std::int64_t>(count) - 1);
    }
    if (are_whole_rows) before = line;
  }
  // Few, or the clock is printed too coarsely.
  [[nodiscard]] bool are_slips(std::int64_t num_rows) const {
    constexpr std::int64_t one_in = 10;
    return are_whole_rows && one_in * std::ssize(rows) < num_rows;
  }
};

class TableFile : public RowsOnClock {
 public:
  TableFile(std::unique_ptr<InputFile> file, const OpenOptions& options)
      : file_(std::move(file)),
        salvage_(options.salvage),
        layout_(table_layout(*file_, options)),
        lines_(*file_, layout_) {
    choose_time(options);
    clock_column_ = layout_.time_column >= 0 ? layout_.time_column : layout_.clock_like_column;
    for (const TableColumn& column : layout_.columns)
      has_words_ = has_words_ || column.holds_moments || column.holds_text;
    describe();
    scan(options);
    lines_ = RowLines(*file_, layout_);
  }

 private:
  [[nodiscard]] Fault fault(std::string name, const std::string& what) const {
    return Fault(FaultKind::input, std::move(name), fmt::format("{}:{}: {}", file_->name(), lines_.number(), what));
  }

  void choose_time(const OpenOptions& options) {
    const auto& wanted = options.time_column;
    if (wanted.empty()) return;
    layout_.time_column = -1;
    layout_.clock_like_column = -1;
    int number = 0;
    const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
    const bool by_number = error == std::errc() && end == wanted.data() + wanted.size();
    for (int i = 0; i < num_columns(); ++i)
      if (by_number ? i + 1 == number : layout_.columns[static_cast<std::size_t>(i)].name == wanted)
        layout_.time_column = i;
    if (layout_.time_column < 0)
      throw Fault(
          FaultKind::usage, "channel.index",
          fmt::format("{}: no time column '{}' among {} columns", file_->name(), clean_name(wanted), num_columns()));
    TableColumn& clock = layout_.columns[static_cast<std::size_t>(layout_.time_column)];
    clock.left_out.clear();
    if (!options.time_unit.empty()) clock.unit = options.time_unit;
  }

  void describe() {
    static constexpr auto separator_name = [](char c) {
      return c == '\t' ? "tab" : c == ';' ? "semicolon" : c == ' ' ? "blank" : c == '|' ? "bar" : "comma";
    };
    info_.container = fmt::format("{}, {} separated{}", layout_.format, separator_name(layout_.style.separator),
                                  layout_.style.decimal_comma ? ", decimal comma" : "");
    for (const TableColumn& column : layout_.columns) {
      info_.columns.push_back(column.name);
      info_.units.push_back(column.unit);
      info_.partial.push_back(!column.left_out.empty());
    }
    info_.checks = layout_.checks;
    info_.named = layout_.named;
    info_.num_runs = layout_.num_runs;
    info_.time_column = layout_.time_column;
  }

  // Counts the fields of a line, keeps the one of the clock; false for a last line that is to be left out: whether its
  // last number is whole does not show without a line end.
  bool scan_row(std::string_view line, std::string_view& time) {
    int count = 0;
    std::string_view field;
    const bool are_plain = clock_column_ < 0 && layout_.style.separator != ' ' && line.find('"') == line.npos;
    auto rest = line;
    for (bool goes_on = are_plain; goes_on; ++count) {  // as Fields does, without looking for quotes
      const auto end = rest.find(layout_.style.separator);
      field = rest.substr(0, end);
      goes_on = end != rest.npos;
      if (goes_on) rest.remove_prefix(end + 1);
    }
    for (Fields fields(line, layout_.style.separator); !are_plain && fields.next(field); ++count)
      if (count == clock_column_) time = field;
    if (count > num_columns()) count -= num_empty_behind(line, count - num_columns());
    if (count == num_columns() || (layout_.comments_behind && count > num_columns())) {
      if (!lines_.ended()) leave_out_last("has no line end, so that its last number may be cut");
      return lines_.ended();
    }
    const auto what = fmt::format("{} columns, want {} as in the rows above", count, num_columns());
    if (lines_.ended()) throw fault("table.ragged", what + fmt::format("; column {} is the last there", count));
    if (!salvage_) throw fault("table.cut", what + ": the last line is cut. Try --salvage to leave it out");
    leave_out_last("is cut");
    return false;
  }

  // Empty fields at the end of a line, at most so many.
  [[nodiscard]] int num_empty_behind(std::string_view line, int most) const {
    int count = 0;
    for (; count < most; ++count) {
      while (line.ends_with(' ') || (line.ends_with('\t') && layout_.style.separator != '\t')) line.remove_suffix(1);
      if (!line.ends_with(layout_.style.separator)) break;
      line.remove_suffix(1);
    }
    return count;
  }

  void leave_out_last(std::string_view why) {
    info_.checks.push_back(
        {"table.cut", "", CheckStatus::warning, static_cast<double>(lines_.number()), 0.0,
         fmt::format("{}:{}: the last line {}; it was left out", file_->name(), lines_.number(), why)});
  }

  void scan(const OpenOptions& options) {
    Stamps stamps{{}, 0.0, layout_.first_line, file_->name()};
    Repeats repeats;
    const double unit_s = clock_column_ >= 0 && !clock().unit.empty() ? find_unit(clock().unit).factor : 1.0;
    std::string_view line, time;
    std::int64_t number = layout_.first_line - 1;
    for (; lines_.next(line); number = lines_.number()) {
      for (; number + 1 < lines_.number(); ++number)
        append(stamps.skipped_before, info_.num_frames, options.max_memory_bytes);
      if (!scan_row(line, time)) break;
      if (layout_.is_one_run && clock_column_ >= 0 && trimmed(time).empty()) break;
      ++info_.num_frames;
      if (clock_column_ < 0) continue;
      append(stamps.time_s, stamp(time, unit_s), options.max_memory_bytes);
      repeats.look_at(stamps.time_s, line);
    }
    if (info_.num_frames == 0) throw fault("table.empty", "no whole row");
    note_headers();
    if (clock_column_ >= 0) stamps.printed_to_s = printed_.coarsest();
    if (options.with_clock && layout_.time_column >= 0 && repeats.are_slips(info_.num_frames))
      leave_out(repeats.rows, stamps);
    if (options.with_clock && layout_.time_column >= 0 && !options.rate_hz)
      refuse_turns(stamps, repeats.are_whole_rows);
    unwrap_counter(stamps, unit_s, info_.checks);
    settle_clock(stamps, options);
    if (options.with_clock && layout_.time_column >= 0) refuse_backwards(stamps);
    if (layout_.time_column < 0 || !options.with_clock) {
      info_.sample_rate_hz = layout_.rate_hz.value_or(0.0);
      return;
    }
    set_clock(
        even_clock(stamps, {.rate_hz = options.rate_hz, .header_rate_hz = layout_.rate_hz, .kind = options.clock}));
    ask_for_unit_of_clock(options);
    if (clock().holds_moments) info_.clock_start.day = moments_.first_day() ? moments_.first_day() : layout_.first_day;
  }

  // Which column is the clock, if one rises as a clock does, and in what unit it is.
  void settle_clock(Stamps& stamps, const OpenOptions& options) {
    const bool is_named = layout_.time_column >= 0;
    if (clock_column_ < 0 || (!is_named && !is_clock_like(stamps.time_s))) return;
    if (!is_named && layout_.rate_hz && !is_on_rate(stamps.time_s, *layout_.rate_hz)) return;  // a ramp
    if (options.with_clock && clock().unit.empty())
      settle_unit(stamps, clock_column_ + 1, is_named, options.rate_hz, info_.checks);
    layout_.time_column = info_.time_column = clock_column_;
  }

  // Milliseconds under a name that says seconds make a record without a vibration.
  void ask_for_unit_of_clock(const OpenOptions& options) {
    constexpr double slowest_hz = 1.0;
    if (info_.sample_rate_hz >= slowest_hz || !(info_.sample_rate_hz > 0.0) || clock().holds_moments ||
        !options.time_unit.empty() || clock().unit != "s")
      return;
    info_.checks.push_back(
        {"clock.slow", "", CheckStatus::warning, info_.sample_rate_hz, slowest_hz,
         fmt::format("{}: the time column is in s, so its rows are {:.4g} s apart. If it is in ms, write name = \"t\", "
                     "index = {}, role = \"t\", unit = \"ms\" into a [[channel]] of the sidecar",
                     file_->name(), 1.0 / info_.sample_rate_hz, layout_.time_column + 1)});
  }

  void note_headers() {
    if (lines_.num_headers() == 0) return;
    info_.checks.push_back({"table.header_again", "", CheckStatus::note, static_cast<double>(lines_.num_headers()), 0.0,
                            fmt::format("{}: the line of names stands between rows, too, {} times; the rows behind "
                                        "it were read on",
                                        file_->name(), lines_.num_headers())});
  }

  // Rows of several channels in turn, each with its label, have each time as often as there are channels.
  void refuse_turns(const Stamps& stamps, bool are_whole_rows) const {
    const auto& time_s = stamps.time_s;
    if (are_whole_rows || time_s.size() < 2 || time_s[0] != time_s[1]) return;
    const auto label = std::find_if(layout_.columns.begin(), layout_.columns.end(),
                                    [](const TableColumn& column) { return column.holds_text; });
    if (label == layout_.columns.end() || !layout_.named) return;
    const auto value = std::find_if(layout_.columns.begin(), layout_.columns.end(), [&](const TableColumn& column) {
      return column.left_out.empty() && &column != &clock();
    });
    if (value == layout_.columns.end()) return;
    const std::string path = path_to_paste(*file_);
    const char separator = layout_.style.separator;
    // $1 time, $2 label, $3 value: a line of labels, then a line for each time.
    constexpr std::string_view command =
        R"(awk -F'{}' '{{sub(/\r$/, "")}} NR < {} {{h = ${}; next}} !(${} in s) {{s[${}]; t[++n] = ${}}} )"
        R"(!(${} in k) {{k[${}]; c[++m] = ${}}} {{v[${}, ${}] = ${}}} END {{printf "%s", h; )"
        R"(for (j = 1; j <= m; ++j) printf "%s%s", FS, c[j]; print ""; for (i = 1; i <= n; ++i) {{printf "%s", t[i]; )"
        R"(for (j = 1; j <= m; ++j) printf "%s%s", FS, v[t[i], c[j]]; print ""}}}}' '{}' > '{}.wide')";
    const int time = clock_column_ + 1, of = static_cast<int>(label - layout_.columns.begin()) + 1,
              is = static_cast<int>(value - layout_.columns.begin()) + 1;
    throw Fault(FaultKind::input, "table.turns",
                fmt::format("{}: several rows have the same time and column {} tells them apart: channels take turns. "
                            "Give each a column: ",
                            file_->name(), file_->quoted(label->name)) +
                    fmt::format(command, separator == '\t' ? "\\t" : std::string(1, separator), layout_.first_line,
                                time, time, time, time, of, of, of, time, of, is, path, path));
  }

  // Where a recorder began anew, or wrote the newest row first.
  void refuse_backwards(const Stamps& stamps) const {
    const auto& time_s = stamps.time_s;
    const auto before = std::adjacent_find(time_s.begin(), time_s.end(), std::greater<>());
    if (before == time_s.end()) return;
    const std::int64_t line = stamps.line(static_cast<std::size_t>(before - time_s.begin()) + 1);
    const std::string path = path_to_paste(*file_);
    const bool newest_first = std::is_sorted(time_s.begin(), time_s.end(), std::greater<>());
    const std::string remedy =
        newest_first ? fmt::format(
                           "The newest row is first. Turn them round: "
                           "(head -n {0} '{2}'; awk 1 '{2}' | tail -n +{1} | tac) > '{2}.forwards'",
                           layout_.first_line - 1, layout_.first_line, path)
                     : fmt::format("If the recorder began anew, read what is before it: head -n {} '{}' > '{}.part'",
                                   line - 1, path, path);
    throw Fault(
        FaultKind::input, "clock.backwards",
        fmt::format("{}:{}: time goes back from {} to {} s. {}", file_->name(), line, *before, *(before + 1), remedy));
  }

  // Rows that a recorder wrote twice.
  void leave_out(const std::vector<std::int64_t>& rows, Stamps& stamps) {
    if (rows.empty()) return;
    const auto is_twice = [&](std::int64_t row) { return std::binary_search(rows.begin(), rows.end(), row); };
    std::vector<double> kept;
    for (std::size_t i = 0; i < stamps.time_s.size(); ++i)
      if (!is_twice(static_cast<std::int64_t>(i))) kept.push_back(stamps.time_s[i]);
    info_.checks.push_back(
        {"table.repeated", "", CheckStatus::note, static_cast<double>(rows.size()), 0.0,
         fmt::format("{}:{}: {} rows are written twice, with the same time and values; each was used "
                     "once",
                     file_->name(), stamps.line(static_cast<std::size_t>(rows.front())), rows.size())});
    std::vector<std::int64_t> skipped;  // each row left out is one more line before the next that is kept
    std::merge(stamps.skipped_before.begin(), stamps.skipped_before.end(), rows.begin(), rows.end(),
               std::back_inserter(skipped));
    for (std::int64_t& row : skipped) row -= std::lower_bound(rows.begin(), rows.end(), row) - rows.begin();
    stamps.skipped_before = std::move(skipped);
    stamps.time_s = std::move(kept);
    info_.num_frames -= std::ssize(rows);
    written_twice_ = rows;
  }

  // By a quarter at a time: old and new together are about what the clock needs afterwards.
  template <typename T>
  void append(std::vector<T>& list, T value, std::size_t max_memory_bytes) const {
    if (list.size() == list.capacity()) {
      const std::size_t more = list.size() + list.size() / 4 + 1024;
      require_memory(file_->name(), clock_bytes_per_row * static_cast<double>(more), max_memory_bytes);
      list.reserve(more);
    }
    list.push_back(value);
  }

  [[nodiscard]] const TableColumn& clock() const { return layout_.columns[static_cast<std::size_t>(clock_column_)]; }
  [[nodiscard]] int num_columns() const { return layout_.style.num_columns; }

  // Seconds since midnight before the first.
  double stamp_of_moment(std::string_view text) {
    const auto moment = parse_moment(text);
    if (!moment || !moment->has_time())
      throw fault("table.cell",
                  fmt::format("column {}: {} is no time of day. Want 10:00:00.123, with or without a date before it",
                              clock_column_ + 1, file_->quoted(text)));
    printed_.note(1.0, moment->digit_s);  // all with as many digits, however large
    return moments_.seconds(*moment);
  }

  double stamp(std::string_view text, double unit_s) {
    if (clock().holds_moments) return stamp_of_moment(text);
    double value = 0;
    if (parse_cell(text, layout_.style.decimal_comma, value) != Cell::number) {
      if (layout_.time_column < 0) return std::numeric_limits<double>::quiet_NaN();
      throw fault("table.cell", fmt::format("column {}: {} is no time", layout_.time_column + 1, file_->quoted(text)));
    }
    printed_.note(value * unit_s, last_digit(text) * unit_s);
    return value * unit_s;
  }

  void finish_reading() override { file_->check_unchanged(); }

  [[nodiscard]] bool holds_words(int column) const {
    const TableColumn& one = layout_.columns[static_cast<std::size_t>(column)];
    return one.holds_moments || one.holds_text;
  }

  // The first cells as long as they are numbers and nothing else, and removes them from the line. How many they are.
  int read_plain(std::string_view& line, Eigen::RowVectorXd& row) const {
    if (layout_.style.separator == ' ' || layout_.style.decimal_comma || has_words_) return 0;
    int column = 0;
    for (; column < num_columns(); ++column) {
      const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), row[column]);
      const auto size = static_cast<std::size_t>(end - line.data());
      if (error != std::errc() || size == line.size() || *end != layout_.style.separator || !std::isfinite(row[column]))
        break;
      line.remove_prefix(size + 1);
    }
    return column;
  }

  void read_row(Eigen::RowVectorXd& row) override {
    std::string_view line, field;
    do {
      if (!lines_.next(line))
        throw Fault(FaultKind::input, "file.changed",
                    fmt::format("{}: became shorter while it was read", file_->name()));
    } while (!written_twice_.empty() && std::binary_search(written_twice_.begin(), written_twice_.end(), num_read_++));
    int column = read_plain(line, row);
    for (Fields fields(line, layout_.style.separator); column < num_columns() && fields.next(field); ++column)
      if (has_words_ && holds_words(column))
        row[column] = std::numeric_limits<double>::quiet_NaN();
      else if (parse_cell(field, layout_.style.decimal_comma, row[column]) == Cell::bad)
        throw fault("table.cell", fmt::format("column {}: {} is no number", column + 1, file_->quoted(field)));
    for (; column < num_columns(); ++column) row[column] = std::numeric_limits<double>::quiet_NaN();
  }

  std::unique_ptr<InputFile> file_;
  bool salvage_;
  TableLayout layout_;
  int clock_column_ = -1;  // what is or could be the clock
  PrintedDigits printed_;  // of it
  MomentClock moments_;
  bool has_words_ = false;                   // dates or text in any column
  std::vector<std::int64_t> written_twice_;  // rows, ascending
  std::int64_t num_read_ = 0;                // counted where rows are written twice
  RowLines lines_;
};

}  // namespace

std::unique_ptr<SampleSource> open_table_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  return std::make_unique<TableFile>(std::move(file), options);
}

}  // namespace dsp
