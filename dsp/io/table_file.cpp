#include "dsp/io/table_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>

#include "dsp/io/found_clock.hpp"
#include "dsp/io/moment.hpp"
#include "dsp/io/rows_on_clock.hpp"
#include "dsp/io/table_layout.hpp"
#include "dsp/io/text_lines.hpp"
#include "dsp/io/units.hpp"
#include "dsp/memory_limit.hpp"
#include "dsp/names.hpp"

namespace dsp {
namespace {

bool is_skipped(std::string_view line) {
  const auto start = line.find_first_not_of(" \t");
  return start == std::string_view::npos || line[start] == '#' || line[start] == '%';
}

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

class TableFile : public RowsOnClock {
 public:
  TableFile(std::unique_ptr<InputFile> file, const OpenOptions& options)
      : file_(std::move(file)), salvage_(options.salvage), layout_(table_layout(*file_)), lines_(rows()) {
    choose_time(options);
    for (std::size_t i = 0; i < layout_.moments.size(); ++i)  // beside the clock, no signals
      if (layout_.moments[i]) layout_.partial[i] = static_cast<int>(i) != layout_.time_column;
    clock_column_ = layout_.time_column >= 0 ? layout_.time_column : layout_.clock_like_column;
    has_moments_ = std::find(layout_.moments.begin(), layout_.moments.end(), true) != layout_.moments.end();
    describe();
    scan(options);
    lines_ = rows();
  }

 private:
  [[nodiscard]] TextLines rows() const { return TextLines(*file_, layout_.data_offset, layout_.first_line); }

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
    for (int i = 0; i < layout_.num_columns; ++i)
      if (by_number ? i + 1 == number : layout_.columns[static_cast<std::size_t>(i)] == wanted) layout_.time_column = i;
    if (layout_.time_column < 0)
      throw Fault(FaultKind::usage, "channel.index",
                  fmt::format("{}: no time column '{}' among {} columns", file_->name(), clean_name(wanted),
                              layout_.num_columns));
    if (!options.time_unit.empty()) layout_.units[static_cast<std::size_t>(layout_.time_column)] = options.time_unit;
  }

  void describe() {
    static constexpr auto separator_name = [](char c) {
      return c == '\t' ? "tab" : c == ';' ? "semicolon" : c == ' ' ? "blank" : "comma";
    };
    info_.container = fmt::format("{}, {} separated{}", layout_.format, separator_name(layout_.separator),
                                  layout_.decimal_comma ? ", decimal comma" : "");
    info_.columns = layout_.columns;
    info_.units = layout_.units;
    info_.partial = layout_.partial;
    info_.named = layout_.named;
    info_.time_column = layout_.time_column;
  }

  // Counts the fields of a line, keeps the one of the clock; false for a last line that is to be left out: whether its
  // last number is whole does not show without a line end.
  bool scan_row(std::string_view line, std::string_view& time) {
    int count = 0;
    std::string_view field;
    const bool are_plain = clock_column_ < 0 && layout_.separator != ' ' && line.find('"') == line.npos;
    auto rest = line;
    for (bool goes_on = are_plain; goes_on; ++count) {  // as Fields does, without looking for quotes
      const auto end = rest.find(layout_.separator);
      field = rest.substr(0, end);
      goes_on = end != rest.npos;
      if (goes_on) rest.remove_prefix(end + 1);
    }
    for (Fields fields(line, layout_.separator); !are_plain && fields.next(field); ++count)
      if (count == clock_column_) time = field;
    if (count == layout_.num_columns + 1 && field.find_first_not_of(" \t") == std::string_view::npos) --count;
    if (count == layout_.num_columns || (layout_.comments_behind && count > layout_.num_columns)) {
      if (!lines_.ended()) leave_out_last("has no line end, so that its last number may be cut");
      return lines_.ended();
    }
    const auto what = fmt::format("{} columns, want {} as in the rows above", count, layout_.num_columns);
    if (lines_.ended()) throw fault("table.ragged", what + fmt::format("; column {} is the last there", count));
    if (!salvage_) throw fault("table.cut", what + ": the last line is cut. Try --salvage to leave it out");
    leave_out_last("is cut");
    return false;
  }

  void leave_out_last(std::string_view why) {
    info_.checks.push_back(
        {"table.cut", "", CheckStatus::warning, static_cast<double>(lines_.number()), 0.0,
         fmt::format("{}:{}: the last line {}; it was left out", file_->name(), lines_.number(), why)});
  }

  void scan(const OpenOptions& options) {
    Stamps stamps{{}, 0.0, layout_.first_line, file_->name()};
    std::string_view line, time;
    while (lines_.next(line)) {
      if (is_skipped(line)) {
        append(stamps.skipped_before, info_.num_frames, options.max_memory_bytes);
        continue;
      }
      if (!scan_row(line, time)) break;
      ++info_.num_frames;
      if (clock_column_ < 0) continue;
      append(stamps.time_s, stamp(time), options.max_memory_bytes);
    }
    if (info_.num_frames == 0) throw fault("table.empty", "no whole row");
    if (clock_column_ >= 0) stamps.printed_to_s = printed_.coarsest();
    if (options.with_clock && layout_.time_column >= 0) require_unit(stamps, options);
    if (layout_.time_column < 0) take_for_clock(stamps, options);
    if (layout_.time_column < 0 || !options.with_clock) {
      info_.sample_rate_hz = layout_.rate_hz.value_or(0.0);
      return;
    }
    set_clock(even_clock(
        stamps, {.rate_hz = options.rate_hz, .header_rate_hz = layout_.rate_hz, .interpolate = options.interpolate}));
    if (layout_.moments[clock()])
      info_.clock_start.day = moments_.first_day() ? moments_.first_day() : layout_.first_day;
  }

  // Time without a unit is in seconds, unless that would be slower than any vibration is sampled.
  void require_unit(const Stamps& stamps, const OpenOptions& options) const {
    const bool is_given = !layout_.units[clock()].empty() || options.rate_hz.has_value();
    constexpr double least_mean_s = 0.4;  // of a clock whose usual step is a second or more, however uneven
    const double span_s = stamps.time_s.back() - stamps.time_s.front();
    if (is_given || !(span_s > least_mean_s * static_cast<double>(stamps.time_s.size()))) return;
    if (is_clock_like(stamps.time_s)) (void)unit_of_clock(stamps, clock_column_ + 1, std::nullopt);
  }

  // A column that nobody called time becomes the clock where it is one to its end and its unit is clear.
  void take_for_clock(Stamps& stamps, const OpenOptions& options) {
    if (clock_column_ < 0 || !is_clock_like(stamps.time_s)) return;
    if (!options.with_clock) layout_.time_column = info_.time_column = clock_column_;
    if (!options.with_clock) return;
    const auto unit = unit_of_clock(stamps, clock_column_ + 1, options.rate_hz);
    if (!unit) {
      info_.checks.push_back(
          {"clock.ignored", "", CheckStatus::warning, *options.rate_hz, 0.0,
           fmt::format(
               "{}: column {} rises evenly as a clock does, but not at the {} Hz that the sidecar says. Correct "
               "the rate, or give the column the role t and its unit",
               file_->name(), clock_column_ + 1, *options.rate_hz)});
      return;
    }
    for (double& time_s : stamps.time_s) time_s *= unit->in_s;
    stamps.printed_to_s *= unit->in_s;
    layout_.time_column = info_.time_column = clock_column_;
    info_.checks.push_back({"clock.assumed", "", CheckStatus::note, unit->in_s, 0.0,
                            fmt::format("{}: column {} rises evenly and was taken for the time in {}", file_->name(),
                                        clock_column_ + 1, unit->name)});
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

  [[nodiscard]] std::size_t clock() const { return static_cast<std::size_t>(clock_column_); }

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

  double stamp(std::string_view text) {
    if (layout_.moments[clock()]) return stamp_of_moment(text);
    double value = 0;
    const auto& unit = layout_.units[clock()];
    const double factor = unit.empty() ? 1.0 : find_unit(unit).factor;
    if (parse_cell(text, layout_.decimal_comma, value) != Cell::number) {
      if (layout_.time_column < 0) return std::numeric_limits<double>::quiet_NaN();
      throw fault("table.cell", fmt::format("column {}: {} is no time", layout_.time_column + 1, file_->quoted(text)));
    }
    printed_.note(value * factor, last_digit(text) * factor);
    return value * factor;
  }

  void finish_reading() override { file_->check_unchanged(); }

  // The first cells as long as they are numbers and nothing else, and removes them from the line. How many they are.
  int read_plain(std::string_view& line, Eigen::RowVectorXd& row) const {
    if (layout_.separator == ' ' || layout_.decimal_comma || has_moments_) return 0;
    int column = 0;
    for (; column < layout_.num_columns; ++column) {
      const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), row[column]);
      const auto size = static_cast<std::size_t>(end - line.data());
      if (error != std::errc() || size == line.size() || *end != layout_.separator || !std::isfinite(row[column]))
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
    } while (is_skipped(line));
    int column = read_plain(line, row);
    for (Fields fields(line, layout_.separator); column < layout_.num_columns && fields.next(field); ++column)
      if (layout_.moments[static_cast<std::size_t>(column)])
        row[column] = std::numeric_limits<double>::quiet_NaN();
      else if (parse_cell(field, layout_.decimal_comma, row[column]) == Cell::bad)
        throw fault("table.cell", fmt::format("column {}: {} is no number", column + 1, file_->quoted(field)));
    for (; column < layout_.num_columns; ++column) row[column] = std::numeric_limits<double>::quiet_NaN();
  }

  std::unique_ptr<InputFile> file_;
  bool salvage_;
  TableLayout layout_;
  int clock_column_ = -1;  // what is or could be the clock
  PrintedDigits printed_;  // of it
  MomentClock moments_;
  bool has_moments_ = false;  // in any column
  TextLines lines_;
};

}  // namespace

std::unique_ptr<SampleSource> open_table_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  return std::make_unique<TableFile>(std::move(file), options);
}

}  // namespace dsp
