#include "dsp/io/uff_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <tuple>

#include "dsp/io/rows_on_clock.hpp"
#include "dsp/io/table_cells.hpp"
#include "dsp/io/table_layout.hpp"
#include "dsp/io/text_lines.hpp"
#include "dsp/io/units.hpp"
#include "dsp/values/memory_limit.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

constexpr std::string_view delimiter = "    -1";

std::string_view columns_of(std::string_view line, std::size_t from, std::size_t count) {
  return from >= line.size() ? std::string_view() : trimmed(line.substr(from, count));
}

std::int64_t whole_number(std::string_view text) {
  std::int64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

// As Fortran writes them: "1.5E-05", "1.5D-05", "+2".
double real_number(std::string_view text) {
  std::string plain(text.substr(text.starts_with('+') ? 1 : 0));
  std::replace(plain.begin(), plain.end(), 'D', 'E');
  double value = 0.0;
  return parse_cell(plain, false, value) == Cell::number ? value : 0.0;
}

/// A function of time in a data set 58, as its header says, and where its numbers are.
struct Set {
  std::string name, unit;
  std::string why_not{};  ///< it is no column; empty where it may be one
  std::int64_t num_values = 0, line = 0;
  bool is_even = true, is_double = false, is_binary = false, is_big = false;
  std::string step{};          ///< of its abscissa, as printed
  double first = 0.0;          ///< its abscissa
  std::uint64_t offset = 0;    ///< of the first number
  std::size_t bytes_of_x = 0;  ///< of each abscissa of an uneven binary set

  [[nodiscard]] auto clock() const { return std::tuple(num_values, is_even, is_even ? step : "", first); }
};

/// The numbers of a set, one after the other.
class Numbers {
 public:
  Numbers(const InputFile& file, const Set& set)
      : file_(&file), set_(&set), offset_(set.offset), lines_(file, set.offset, set.line) {}

  /// x: of an uneven set; NaN else. Throws Fault where there is none.
  void next(double& x, double& y) {
    x = std::numeric_limits<double>::quiet_NaN();
    if (set_->is_binary) {
      if (!set_->is_even) x = binary(set_->bytes_of_x);
      y = binary(set_->is_double ? 8 : 4);
    } else {
      if (!set_->is_even) x = text();
      y = text();
    }
  }

 private:
  double binary(std::size_t size) {
    if (at_ + size > buffer_.size()) {
      constexpr std::size_t piece = std::size_t{1} << 16;
      offset_ += at_;
      at_ = 0;
      buffer_ = file_->text(offset_, piece);
      if (buffer_.size() < size) throw cut();
    }
    std::array<char, 8> bytes{};
    std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(at_), size, bytes.begin());
    at_ += size;
    if (set_->is_big == (std::endian::native == std::endian::little))
      std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    if (size == 8) return std::bit_cast<double>(bytes);
    float value = 0.0F;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }

  double text() {
    while (true) {
      const auto begin = line_.find_first_not_of(" \t+");
      if (begin != line_.npos) {
        line_.remove_prefix(begin);
        break;
      }
      if (!lines_.next(line_) || line_ == delimiter) throw cut();
      if (line_.find('D') == line_.npos) continue;
      plain_.assign(line_);
      std::replace(plain_.begin(), plain_.end(), 'D', 'E');
      line_ = plain_;
    }
    double value = 0.0;
    const auto [end, error] = std::from_chars(line_.data(), line_.data() + line_.size(), value);
    if (error == std::errc::invalid_argument)
      throw Fault(FaultKind::input, "uff.damaged",
                  fmt::format("{}:{}: {} is no number", file_->name(), lines_.number(), file_->quoted(line_)));
    line_.remove_prefix(static_cast<std::size_t>(end - line_.data()));
    return value;
  }

  [[nodiscard]] Fault cut() const {
    return Fault(
        FaultKind::input, "uff.damaged",
        fmt::format("{}: the set '{}' ends before its {} values", file_->name(), set_->name, set_->num_values));
  }

  const InputFile* file_;
  const Set* set_;
  std::uint64_t offset_;
  std::string buffer_, plain_;
  std::size_t at_ = 0;
  TextLines lines_;
  std::string_view line_;
};

/// The data sets of a file, one after the other.
class Sets {
 public:
  Sets(const InputFile& file, const OpenOptions& options) : file_(file), salvage_(options.salvage) { walk(); }

  std::vector<Set> found;
  std::vector<std::string> others;  ///< what else it holds

 private:
  [[nodiscard]] Fault truncated(const std::string& what) const {
    return Fault(FaultKind::input, "container.truncated",
                 fmt::format("{}: {}. Try --salvage to read the sets before it", file_.name(), what));
  }

  [[nodiscard]] std::string next_line(TextLines& lines) const {
    std::string_view line;
    if (!lines.next(line)) throw truncated("ends in the header of a data set");
    return std::string(line);
  }

  void walk() {
    TextLines lines(file_);
    std::string_view line;
    while (lines.next(line)) {
      if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);
      if (trimmed(line).empty()) continue;
      if (trimmed(line) != trimmed(delimiter))
        throw Fault(FaultKind::input, "uff.damaged",
                    fmt::format("{}:{}: want a line of -1 between data sets, got {}", file_.name(), lines.number(),
                                file_.quoted(line.substr(0, 80))));
      try {
        read_set(lines);
      } catch (const Fault& fault) {
        if (!salvage_ || fault.name() != "container.truncated") throw;
        others.push_back(fmt::format("a set that is cut, from line {} on", lines.number()));
        return;
      }
    }
  }

  void read_set(TextLines& lines) {
    number_is_open_ = false;
    const std::string kind = next_line(lines);
    const bool is_binary = kind.size() > 6 && kind[6] == 'b';
    const std::int64_t number = whole_number(columns_of(kind, 0, 6));
    std::array<std::string, 11> header;
    if (number == 58)
      for (auto& one : header) one = next_line(lines);
    const std::uint64_t promised =
        is_binary ? static_cast<std::uint64_t>(std::max<std::int64_t>(0, whole_number(columns_of(kind, 31, 12)))) : 0;
    if (number == 58) add(kind, header, lines, is_binary, promised);
    if (number == 164) read_units(lines);
    if (number != 58 && number != 164 && number != 151) others.push_back(fmt::format("data set {}", number));
    if (is_binary) {
      for (std::int64_t i = number == 58 ? 11 : 0; i < whole_number(columns_of(kind, 19, 12)); ++i)
        (void)next_line(lines);
      const std::uint64_t end = behind(lines) + promised;
      if (promised > file_.size() || end > file_.size()) throw lost("ends in the numbers of a data set");
      lines = TextLines(file_, end, lines.number() + 1);
    }
    std::string_view line;
    while (lines.next(line))
      if (line.starts_with(delimiter) && trimmed(line) == trimmed(delimiter)) return;
    throw lost("ends in a data set");
  }

  // The set that was read last is not whole.
  Fault lost(const std::string& what) {
    if (!found.empty() && number_is_open_) found.pop_back();
    return truncated(what);
  }

  // The first byte behind the line returned last.
  [[nodiscard]] std::uint64_t behind(const TextLines& lines) const {
    std::uint64_t at = lines.offset();
    for (constexpr std::size_t piece = 4096;; at += piece) {
      const std::string text = file_.text(at, piece);
      if (const auto end = text.find('\n'); end != text.npos) return at + end + 1;
      if (text.size() < piece) return at + text.size();
    }
  }

  void read_units(TextLines& lines) {
    std::string_view line;
    if (!lines.next(line) || !lines.next(line)) return;
    if (const double factor = real_number(columns_of(line, 0, 25)); factor > 0.0) length_factor_ = factor;
  }

  // The unit of a kind of data where its axis has none: lengths are in 1 / factor m.
  [[nodiscard]] std::string usual_unit(std::int64_t kind) const {
    std::string length;
    for (const char* name : {"m", "mm", "in", "um"})
      if (constexpr double same = 1e-4; std::abs(length_factor_ * find_unit(name).factor - 1.0) < same) length = name;
    constexpr std::int64_t displacement = 8, velocity = 11, acceleration = 12;
    const std::string unit = length + (kind == displacement ? "" : kind == velocity ? "/s" : "/s^2");
    return kind == displacement || kind == velocity || kind == acceleration ? (is_unit(unit) ? unit : "") : "";
  }

  static std::string name_of(const std::string& identity, const std::string& dof) {
    static constexpr std::array directions{"", "X", "Y", "Z", "RX", "RY", "RZ"};
    const auto name = columns_of(dof, 31, 10);
    if (!name.empty() && name != "NONE") return clean_name(name);
    const auto node = columns_of(dof, 41, 10);
    const std::int64_t direction = whole_number(columns_of(dof, 51, 4));
    const auto which = static_cast<std::size_t>(std::abs(direction));
    if (!node.empty() && node != "0" && which < directions.size())
      return clean_name(fmt::format("{}{}{}", node, direction < 0 ? "-" : "", directions[which]));
    return clean_name(identity);
  }

  void add(const std::string& kind, const std::array<std::string, 11>& header, const TextLines& lines, bool is_binary,
           std::uint64_t promised) {
    const std::string &dof = header[5], &form = header[6], &abscissa = header[7], &ordinate = header[8];
    Set set;
    set.name = name_of(header[0], dof);
    set.line = lines.number() + 1;
    set.offset = behind(lines);
    set.is_binary = is_binary;
    set.is_big = whole_number(columns_of(kind, 7, 6)) == 2;
    const std::int64_t type = whole_number(columns_of(form, 0, 10));
    set.num_values = whole_number(columns_of(form, 10, 10));
    set.is_even = whole_number(columns_of(form, 20, 10)) != 0;
    set.first = real_number(columns_of(form, 30, 13));
    set.step = columns_of(form, 43, 13);
    set.is_double = type == 4;
    const auto label = columns_of(ordinate, 46, 21);
    set.unit = is_unit(label) ? std::string(label) : usual_unit(whole_number(columns_of(ordinate, 0, 10)));
    const std::int64_t function = whole_number(columns_of(dof, 0, 5)), over = whole_number(columns_of(abscissa, 0, 10));
    constexpr std::int64_t time = 17, response = 1, ieee = 2;
    if (over != time && !(over == 0 && function <= response))
      set.why_not = "no function of time";
    else if (type != 2 && type != 4)
      set.why_not = "complex numbers";
    else if (is_binary && whole_number(columns_of(kind, 13, 6)) > ieee)
      set.why_not = "numbers that are not IEEE 754";
    if (set.num_values < 1) set.why_not = "empty";
    if (set.why_not.empty()) check_size(set, promised);
    number_is_open_ = set.why_not.empty();
    found.push_back(std::move(set));
  }

  // At least so many bytes are there as its numbers need.
  void check_size(Set& set, std::uint64_t promised) const {
    const std::uint64_t left = file_.size() - std::min(file_.size(), set.offset);
    const auto count = static_cast<std::uint64_t>(set.num_values);
    if (count > left)
      throw truncated(fmt::format("promises {} values of '{}' and has no room for them", count, set.name));
    if (!set.is_binary) return;
    const std::uint64_t size = set.is_double ? 8 : 4;
    set.bytes_of_x = set.is_even ? 0 : promised >= 2 * size * count ? size : 4;
    if (promised < (size + set.bytes_of_x) * count)
      throw Fault(FaultKind::input, "uff.damaged",
                  fmt::format("{}: '{}' promises {} values in {} bytes", file_.name(), set.name, count, promised));
  }

  const InputFile& file_;
  bool salvage_;
  bool number_is_open_ = false;  // the set found last is a column
  double length_factor_ = 1.0;
};

class UffFile : public RowsOnClock {
 public:
  UffFile(std::unique_ptr<InputFile> file, const OpenOptions& options) : file_(std::move(file)) {
    Sets sets(*file_, options);
    info_.left_out = std::move(sets.others);
    choose(std::move(sets.found));
    name_columns();
    if (!info_.left_out.empty())
      info_.checks.push_back({"uff.left_out", "", CheckStatus::note, static_cast<double>(info_.left_out.size()), 0.0,
                              fmt::format("{}: not read: {}{}", file_->name(), info_.left_out.front(),
                                          info_.left_out.size() > 1 ? " and others" : "")});
    settle_clock(options);
    for (const Set& set : sets_) numbers_.emplace_back(*file_, set);
  }

 private:
  // The sets of one length, rate and start, of which there are most.
  void choose(std::vector<Set> found) {
    std::map<decltype(found.front().clock()), int> counts;
    for (const Set& set : found)
      if (set.why_not.empty()) ++counts[set.clock()];
    const auto most = std::max_element(counts.rbegin(), counts.rend(),
                                       [](const auto& one, const auto& other) { return one.second < other.second; });
    for (Set& set : found) {
      if (set.why_not.empty() && set.clock() != most->first)
        set.why_not = fmt::format("{} values, others have {}", set.num_values, std::get<0>(most->first));
      if (set.why_not.empty())
        sets_.push_back(set);
      else
        info_.left_out.push_back(fmt::format("{} ({})", set.name, set.why_not));
    }
    if (sets_.empty())
      throw Fault(FaultKind::input, "uff.no_signal",
                  fmt::format("{}: holds no function of time of real numbers (data set 58){}", file_->name(),
                              info_.left_out.empty() ? "" : fmt::format(", only {}", info_.left_out.front())));
  }

  // Names that occur twice are told apart by a number.
  void name_columns() {
    info_.container = fmt::format("UFF, data set 58{}", sets_.front().is_binary ? "b" : "");
    info_.named = true;
    std::map<std::string, int> counts;
    for (const Set& set : sets_) {
      const int count = ++counts[set.name];
      info_.columns.push_back(count == 1 ? set.name : fmt::format("{} set {}", set.name, count));
      info_.units.push_back(set.unit);
    }
    info_.partial.resize(sets_.size());
  }

  void settle_clock(const OpenOptions& options) {
    const Set& set = sets_.front();
    info_.num_frames = set.num_values;
    if (set.is_even) {
      const double step_s = real_number(set.step);
      Clock clock;
      clock.start_s = set.first;
      clock.num_frames = set.num_values;
      if (step_s > 0.0) clock.rate_hz = roundest_rate(1.0 / step_s, 0.5 * last_digit(set.step) / step_s);
      return set_clock(std::move(clock));
    }
    require_memory(file_->name(), clock_bytes_per_row * static_cast<double>(set.num_values), options.max_memory_bytes);
    Stamps stamps{{}, 0.0, set.line, file_->name()};
    Numbers numbers(*file_, set);
    double x = 0.0, y = 0.0;
    for (std::int64_t i = 0; i < set.num_values; ++i) {
      numbers.next(x, y);
      stamps.time_s.push_back(x);
    }
    const double digit = !set.is_binary ? 1e-5 : set.bytes_of_x == 4 ? std::numeric_limits<float>::epsilon() : 0.0;
    stamps.printed_to_s = digit * std::abs(stamps.time_s.back());
    if (options.with_clock) set_clock(even_clock(stamps, {.rate_hz = options.rate_hz, .kind = options.clock}));
  }

  void read_row(Eigen::RowVectorXd& row) override {
    double x = 0.0;
    for (std::size_t c = 0; c < numbers_.size(); ++c) numbers_[c].next(x, row[static_cast<Eigen::Index>(c)]);
  }
  void finish_reading() override { file_->check_unchanged(); }

  std::unique_ptr<InputFile> file_;
  std::vector<Set> sets_;
  std::vector<Numbers> numbers_;
};

}  // namespace

bool is_uff(std::string_view head) {
  if (head.starts_with("\xef\xbb\xbf")) head.remove_prefix(3);
  while (true) {
    const auto end = std::min(head.find('\n'), head.size());
    const std::string_view line = head.substr(0, end), text = line.substr(0, line.find_last_not_of(" \t\r") + 1);
    if (!text.empty()) return text == delimiter;
    if (end == head.size()) return false;
    head.remove_prefix(end + 1);
  }
}

std::unique_ptr<SampleSource> open_uff_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  return std::make_unique<UffFile>(std::move(file), options);
}

}  // namespace dsp
