#include "dsp/io/array_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>

#include "dsp/io/array_labels.hpp"
#include "dsp/io/channel_roles.hpp"
#include "dsp/io/found_clock.hpp"
#include "dsp/io/rows_on_clock.hpp"
#include "dsp/io/table_header.hpp"
#include "dsp/io/table_layout.hpp"
#include "dsp/io/units.hpp"
#include "dsp/values/memory_limit.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

std::vector<std::int64_t> long_sides(const FileArray& array) {
  std::vector<std::int64_t> sides;
  for (const std::int64_t side : array.shape)
    if (side != 1) sides.push_back(side);
  return sides;
}

std::string described(const FileArray& array) {
  std::string size;
  for (const std::int64_t side : array.shape) size += fmt::format("{}{}", size.empty() ? "" : "x", side);
  return size.empty() ? array.kind : fmt::format("{} {}", size, array.kind);
}

// Of a vector of numbers, 0 for anything else.
std::int64_t length(const FileArray& array) {
  const auto sides = long_sides(array);
  return array.values != ValueKind::none && sides.size() == 1 ? sides[0] : 0;
}

std::int64_t longer_side(const FileArray& array) {
  const auto sides = long_sides(array);
  return array.values != ValueKind::none && sides.size() == 2 ? std::max(sides[0], sides[1]) : 0;
}

// Along which of its long sides it is so long, where it is along one alone; -1: it has no columns.
int axis_of(const FileArray& array, std::int64_t num_frames) {
  const auto sides = long_sides(array);
  if (array.values == ValueKind::none || num_frames < 2) return -1;
  if (sides.size() == 1) return sides[0] == num_frames ? 0 : -1;
  if (sides.size() != 2 || sides[0] == 0 || sides[1] == 0 || (sides[0] == num_frames) == (sides[1] == num_frames))
    return -1;
  return sides[0] == num_frames ? 0 : 1;
}

bool is_time(const FileArray& array) {
  return is_time_name(split_unit(array.name).base) || is_time_name(split_unit(name_of_values(array)).base);
}

class ArrayFile final : public RowsOnClock {
 public:
  ArrayFile(std::unique_ptr<InputFile> file, ArrayContents contents, const OpenOptions& options)
      : file_(std::move(file)), contents_(std::move(contents)), name_(file_ ? file_->name() : contents_.name) {
    for (FileArray& array : contents_.arrays) array.name = clean_name(array.name), array.group = clean_group(array);
    info_.container = contents_.container;
    info_.num_frames = find_length();
    choose_arrays();
    load(options);
    leave_out_other_clocks();
    read_rate();
    describe_columns(options);
    info_.checks.insert(info_.checks.end(), contents_.checks.begin(), contents_.checks.end());
    check_left_out();
    set_time(options);
  }

 private:
  /// An array that is used: its columns begin at `first`.
  struct Used {
    const FileArray* array;
    int axis = 0;
    std::size_t first = 0, count = 1;
  };

  static std::string clean_group(const FileArray& array) {
    return array.group.empty() ? "" : clean_name(array.group.substr(0, array.group.size() - 1)) + array.group.back();
  }

  void finish_reading() override {
    if (file_) file_->check_unchanged();
    used_ = {};  // nothing asks for them again
    contents_.arrays = {};
  }

  void read_row(Eigen::RowVectorXd& row) override {
    constexpr std::int64_t block_values = 1 << 15, fewest_rows = 64;
    const auto width = static_cast<std::int64_t>(info_.columns.size());
    if (next_row_ == block_end_) {
      const std::int64_t count =
          std::min(num_rows_ - next_row_, std::max(fewest_rows, block_values / std::max<std::int64_t>(width, 1)));
      block_.resize(static_cast<std::size_t>(count * width));
      for (const Used& one : used_)
        one.array->read(one.axis, next_row_, count, block_.data() + static_cast<std::size_t>(count) * one.first);
      block_first_ = next_row_;
      block_end_ += count;
    }
    const auto at = static_cast<std::size_t>(next_row_ - block_first_),
               num_rows = static_cast<std::size_t>(block_end_ - block_first_);
    for (const Used& one : used_) {
      const double* const values = block_.data() + num_rows * one.first + at * one.count;
      for (std::size_t k = 0; k < one.count; ++k) row[static_cast<Eigen::Index>(one.first + k)] = values[k];
    }
    ++next_row_;
  }

  // Columns are as long as the longest vector; a shorter one is a parameter. Matrices count where there is no vector,
  // or none that is more than a line of one.
  std::int64_t find_length() {
    constexpr std::int64_t much_longer = 10;
    std::int64_t longest = 0, widest = 0;
    for (const FileArray& array : contents_.arrays) {
      longest = std::max(longest, length(array));
      widest = std::max(widest, longer_side(array));
    }
    num_rows_ = longest > 1 && widest < much_longer * longest ? longest : widest;
    return num_rows_;
  }

  void choose_arrays() {
    for (const FileArray& array : contents_.arrays) {
      if (const int axis = axis_of(array, num_rows_); axis >= 0)
        used_.push_back({&array, axis});
      else
        leave_out(array);
    }
    if (!used_.empty()) return;
    info_.left_out.insert(info_.left_out.end(), contents_.left_out.begin(), contents_.left_out.end());
    throw Fault(
        FaultKind::input, contents_.prefix + ".no_variable",
        fmt::format("{}: holds {}; want real vectors (n x 1) of one length", name_,
                    info_.left_out.empty() ? "no variable" : fmt::format("{}", fmt::join(info_.left_out, ", "))));
  }

  void load(const OpenOptions& options) {
    for (const Used& one : used_) bytes_ += one.array->bytes;
    require_memory(name_, bytes_, options.max_memory_bytes);
    for (const Used& one : used_)
      if (one.array->load) one.array->load();
    for (FileArray& array : contents_.arrays)
      if (array.read_texts) array.texts = array.read_texts();
  }

  [[nodiscard]] bool is_same(const Used& one, const Used& other) const {
    constexpr std::int64_t block_rows = 1 << 14;
    std::vector<double> a(block_rows), b(block_rows);
    for (std::int64_t at = 0; at < num_rows_; at += block_rows) {
      const std::int64_t count = std::min(block_rows, num_rows_ - at);
      one.array->read(one.axis, at, count, a.data());
      other.array->read(other.axis, at, count, b.data());
      if (!std::equal(a.begin(), a.begin() + count, b.begin())) return false;
    }
    return true;
  }

  // Groups with a clock that is not the first one's, and further clocks that are.
  void leave_out_other_clocks() {
    const Used* clock = nullptr;
    std::vector<std::string> elsewhere;
    std::vector<const FileArray*> twice;
    for (const Used& one : used_) {
      if (!is_time(*one.array) || long_sides(*one.array).size() != 1) continue;
      if (clock == nullptr)
        clock = &one;
      else if (one.array->group != clock->array->group)
        is_same(one, *clock) ? twice.push_back(one.array) : elsewhere.push_back(one.array->group);
    }
    const auto is_elsewhere = [&](const Used& one) {
      const std::string& own = one.array->group;
      return std::any_of(elsewhere.begin(), elsewhere.end(), [&](const std::string& group) {
        return group.empty() ? own.empty() : own.starts_with(group);
      });
    };
    for (const std::string& group : elsewhere) {
      info_.left_out.push_back(
          fmt::format("{} (on a clock of its own)", group.substr(0, std::max<std::size_t>(group.size(), 1) - 1)));
      lost_ = true;
    }
    std::erase_if(used_, [&](const Used& one) {
      return is_elsewhere(one) || std::find(twice.begin(), twice.end(), one.array) != twice.end();
    });
  }

  // A number by itself that is called as rates and steps are, or what the container states.
  void read_rate() {
    if (contents_.rate_hz > 0.0) rate_hz_ = contents_.rate_hz;
    for (const Used& one : used_)
      if (one.array->rate_hz > 0.0) rate_hz_ = one.array->rate_hz;
    for (const FileArray& array : contents_.arrays) {
      const NamedUnit split = split_unit(array.name);
      auto rate = rate_name(array.name);
      if (!rate && (rate = rate_name(split.base)) && !split.unit.empty() &&
          find_unit(split.unit).si == (rate->is_step ? "s" : "Hz"))
        rate->factor = find_unit(split.unit).factor;
      if (!rate || array.values == ValueKind::none || !long_sides(array).empty()) continue;
      if (array.load) array.load();
      double value = 0.0;
      array.read(0, 0, 1, &value);
      const double rate_hz = rate->rate_hz(value);
      if (rate_hz == 0.0) continue;
      constexpr double rounding = 1e-12;
      rate_hz_ = roundest_rate(rate_hz, rounding);
      not_left_out(array);
    }
  }

  void not_left_out(const FileArray& array) {
    std::erase_if(info_.left_out,
                  [&](const std::string& one) { return one.starts_with(array.group + array.name + " ("); });
  }

  void leave_out(const FileArray& array) {
    const auto own = length(array);
    const std::string name = array.group + array.name;
    info_.left_out.push_back(own > 1 ? fmt::format("{} ({} values, the longest {})", name, own, num_rows_)
                             : array.texts.size() == 1 ? fmt::format("{} ('{}')", name, clean_name(array.texts.front()))
                                                       : fmt::format("{} ({})", name, described(array)));
    // A number by itself and a text are no signals.
    const bool is_one = long_sides(array).empty();
    lost_ = lost_ || (!is_one && array.kind != "char" && array.kind != "text") || array.kind == "struct" ||
            array.kind == "cell";
  }

  void describe_columns(const OpenOptions& options) {
    std::map<std::string, int> named;
    for (const Used& one : used_) ++named[one.array->name];
    info_.named = std::any_of(used_.begin(), used_.end(), [](const Used& one) { return !one.array->name.empty(); });
    const ArrayLabels labels(contents_.arrays);
    for (Used& one : used_) {
      const FileArray& array = *one.array;
      const FileArray *names = nullptr, *units = nullptr;
      const auto sides = long_sides(array);
      one.first = info_.columns.size();
      one.count = sides.size() == 1 ? 1 : static_cast<std::size_t>(sides[one.axis == 0 ? 1 : 0]);
      require_memory(name_, 100.0 * static_cast<double>(one.first + one.count), options.max_memory_bytes);
      names = labels.names_beside(array, one.count);
      units = labels.units_beside(array, one.count);
      const std::string values = units != nullptr ? name_of_values(array) : "";
      const std::string name = !values.empty() ? values : named[array.name] > 1 ? array.group + array.name : array.name;
      for (std::size_t i = 0; i < one.count; ++i) {
        const NamedUnit split = split_unit(names != nullptr ? clean_name(names->texts[i]) : name);
        const std::string stated = units != nullptr ? units->texts[i] : array.unit;
        const bool is_numbered = names == nullptr && one.count > 1 && !name.empty();
        add_column(is_numbered        ? fmt::format("{}_{}", split.base, i + 1)
                   : names != nullptr ? names->texts[i]
                                      : name,
                   is_unit(stated) ? stated : split.unit, is_unit(stated) || is_no_unit(stated) ? "" : stated);
      }
      for (const FileArray* label : {names, units})
        if (label != nullptr) not_left_out(*label);
      note_numbers(array, name);
    }
    info_.partial.resize(info_.columns.size());
    take_listed_units();
    find_time_column(options);
    leave_out_counts();
  }

  // As many units in one list as there are columns, all of its group and none with a unit of its own. Containers sort
  // their variables, JSON does not: elsewhere a unit of time must come to the clock, and to nothing else.
  void take_listed_units() {
    if (std::any_of(info_.units.begin(), info_.units.end(), [](const std::string& unit) { return !unit.empty(); }))
      return;
    const std::string& group = used_.front().array->group;
    if (std::any_of(used_.begin(), used_.end(), [&](const Used& one) { return one.array->group != group; })) return;
    const ArrayLabels labels(contents_.arrays);
    const FileArray* units = labels.units_beside(*used_.front().array, info_.columns.size());
    if (units == nullptr || units->texts.size() < 2 || units->group != group) return;
    bool has_clock = false, fits = true;
    for (std::size_t i = 0; i < info_.units.size(); ++i) {
      const bool is_clock = is_time_name(info_.columns[i]);
      has_clock = has_clock || is_clock;
      fits = fits && is_clock == (is_unit(units->texts[i]) && parse_quantity("1 " + units->texts[i]).si == "s");
    }
    if (contents_.prefix != "json" && !(has_clock && fits)) return;
    for (std::size_t i = 0; i < info_.units.size(); ++i)
      if (is_unit(units->texts[i])) info_.units[i] = units->texts[i];
    not_left_out(*units);
  }

  // 0, 1, 2, ...: an index of rows.
  void leave_out_counts() {
    constexpr std::int64_t looked_at = 250, fewest = 8;  // fewer rise by ones by chance
    for (const Used& one : used_) {
      const std::string& name = info_.columns[one.first];
      if (one.count != 1 || num_rows_ < fewest || name.empty() || static_cast<int>(one.first) == info_.time_column ||
          names_signal(name))
        continue;
      const std::vector<double> steps = steps_of(values_of(one.first, looked_at));
      if (std::any_of(steps.begin(), steps.end(), [](double step) { return step != 1.0; })) continue;
      info_.partial[one.first] = true;
      info_.left_out.push_back(fmt::format("{} (counts rows)", name));
    }
  }

  // A unit that is not known stays in the name, as where the name itself has it.
  void add_column(const std::string& name, std::string unit, const std::string& unknown_unit) {
    const bool is_unknown = unit.empty() && !unknown_unit.empty();
    info_.columns.push_back(clean_name(is_unknown ? fmt::format("{} ({})", name, unknown_unit) : name));
    info_.units.push_back(std::move(unit));
  }

  void find_time_column(const OpenOptions& options) {
    for (const Used& one : used_)
      for (std::size_t i = one.first; i < one.first + one.count && info_.time_column < 0; ++i) {
        const bool wanted =
            options.time_column.empty()
                ? is_time(*one.array) || is_time_name(split_unit(info_.columns[i]).base)
                : options.time_column == info_.columns[i] || options.time_column == std::to_string(i + 1);
        if (wanted) info_.time_column = static_cast<int>(i);
      }
    if (!options.time_column.empty() && info_.time_column < 0)
      throw Fault(FaultKind::input, "channel.column",
                  fmt::format("{}: no time column '{}'; there are {}", name_, clean_name(options.time_column),
                              fmt::join(info_.columns, ", ")));
  }

  void note_numbers(const FileArray& array, const std::string& name) {
    if (array.values == ValueKind::integers && !is_time(array) && !array.kind.starts_with("logical"))
      info_.checks.push_back(
          {contents_.prefix + ".integer", name, CheckStatus::warning, 0.0, 0.0,
           fmt::format("{}: its {} are taken as they are. If they are counts of a converter, say in the sidecar what "
                       "one is worth (full_scale)",
                       name_, described(array))});
    const std::size_t rounded = array.num_rounded ? array.num_rounded() : 0;
    if (rounded > 0)
      info_.checks.push_back({contents_.prefix + ".rounded", name, CheckStatus::warning, static_cast<double>(rounded),
                              0.0,
                              fmt::format("{}: {} of its whole numbers have more than 53 bits and lose their last "
                                          "digits. Subtract what they have in common before they are saved",
                                          name_, rounded)});
  }

  [[nodiscard]] const Used& holder_of(std::size_t column) const {
    return *std::find_if(used_.begin(), used_.end(),
                         [&](const Used& one) { return column >= one.first && column < one.first + one.count; });
  }

  [[nodiscard]] std::vector<double> values_of(std::size_t column, std::int64_t most) const {
    const Used& one = holder_of(column);
    const std::int64_t count = std::min(most, num_rows_);
    const std::int64_t block_rows = std::max<std::int64_t>(1, (1 << 15) / static_cast<std::int64_t>(one.count));
    std::vector<double> values(static_cast<std::size_t>(count)), block;
    for (std::int64_t at = 0; at < count; at += block_rows) {
      const std::int64_t rows = std::min(block_rows, count - at);
      block.resize(static_cast<std::size_t>(rows) * one.count);
      one.array->read(one.axis, at, rows, block.data());
      for (std::int64_t i = 0; i < rows; ++i)
        values[static_cast<std::size_t>(at + i)] = block[static_cast<std::size_t>(i) * one.count + column - one.first];
    }
    return values;
  }

  // The only column that could be a clock and has no signal's name; -1: none.
  [[nodiscard]] int clock_like_column(const OpenOptions& options) const {
    constexpr std::int64_t looked_at = 250;
    constexpr std::size_t most_columns = 1000;
    int found = -1;
    for (std::size_t i = 0; i < std::min(info_.columns.size(), most_columns); ++i) {
      const auto is = [&](const std::string& one) { return one == info_.columns[i] || one == std::to_string(i + 1); };
      if (!info_.units[i].empty() || names_signal(info_.columns[i]) ||
          std::any_of(options.signal_columns.begin(), options.signal_columns.end(), is))
        continue;
      if (!is_clock_like(values_of(i, looked_at))) continue;
      if (found >= 0) return -1;
      found = static_cast<int>(i);
    }
    return found;
  }

  void set_time(const OpenOptions& options) {
    info_.sample_rate_hz = rate_hz_.value_or(0.0);
    const bool is_named = info_.time_column >= 0;
    if (!is_named) info_.time_column = clock_like_column(options);
    constexpr std::int64_t looked_at = 250;
    if (!is_named && info_.time_column >= 0 && rate_hz_ &&
        !is_on_rate(values_of(static_cast<std::size_t>(info_.time_column), looked_at), *rate_hz_))
      info_.time_column = -1;
    if (info_.time_column < 0 || !options.with_clock) return;
    require_memory(name_, bytes_ + clock_bytes_per_row * static_cast<double>(num_rows_), options.max_memory_bytes);
    const auto at = static_cast<std::size_t>(info_.time_column);
    const auto& unit = options.time_unit.empty() ? info_.units[at] : options.time_unit;
    const double factor = unit.empty() ? 1.0 : find_unit(unit).factor;
    Stamps stamps{values_of(at, num_rows_), 0.0, 1, name_};
    for (double& time_s : stamps.time_s) time_s *= factor;
    const ValueKind kind = holder_of(at).array->values;
    if (kind == ValueKind::singles)
      stamps.printed_to_s = std::numeric_limits<float>::epsilon() * std::abs(stamps.time_s.back());
    else if (kind == ValueKind::integers)
      stamps.printed_to_s = factor;
    if (!is_named && !is_clock_like(stamps.time_s)) {
      info_.time_column = -1;
      return;
    }
    if (unit.empty()) settle_unit(stamps, info_.time_column + 1, is_named, options.rate_hz, info_.checks);
    set_clock(even_clock(stamps, {.rate_hz = options.rate_hz, .header_rate_hz = rate_hz_, .kind = options.clock}));
  }

  void check_left_out() {
    info_.left_out.insert(info_.left_out.end(), contents_.left_out.begin(), contents_.left_out.end());
    if (info_.left_out.empty()) return;
    constexpr std::size_t most_named = 20;
    const std::vector<std::string> named(info_.left_out.begin(),
                                         info_.left_out.begin() + std::min(most_named, info_.left_out.size()));
    info_.checks.push_back({contents_.prefix + ".left_out", "", lost_ ? CheckStatus::warning : CheckStatus::note,
                            static_cast<double>(info_.left_out.size()), 0.0,
                            fmt::format("{}: not read, being no real numbers as long as the longest vector: {}{}",
                                        name_, fmt::join(named, ", "),
                                        named.size() < info_.left_out.size()
                                            ? fmt::format(" and {} more", info_.left_out.size() - named.size())
                                            : "")});
  }

  std::unique_ptr<InputFile> file_;
  ArrayContents contents_;
  std::string name_;
  std::vector<Used> used_;
  double bytes_ = 0.0;             // of the arrays that were loaded
  std::optional<double> rate_hz_;  // that the file states
  bool lost_ = false;              // whether what is left out may be a signal
  std::vector<double> block_;      // the rows around the next, array after array
  std::int64_t num_rows_ = 0, next_row_ = 0, block_first_ = 0, block_end_ = 0;
};

template <typename T>
double stored(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

double half(const char* at) {
  std::uint16_t bits = 0;
  std::memcpy(&bits, at, sizeof bits);
  constexpr int mantissa_bits = 10, bias = 15, special = 31;
  const int exponent = bits >> mantissa_bits & special, mantissa = bits & ((1 << mantissa_bits) - 1);
  const double size = exponent == special ? (mantissa == 0 ? HUGE_VAL : std::nan(""))
                      : exponent == 0     ? std::ldexp(mantissa, 1 - bias - mantissa_bits)
                                      : std::ldexp((1 << mantissa_bits) + mantissa, exponent - bias - mantissa_bits);
  return bits >> 15 != 0 ? -size : size;
}

}  // namespace

bool NumberFormat::is_known() const {
  const bool is_whole = kind == 'i' || kind == 'u';
  return bytes == 2 || bytes == 4 || bytes == 8 ? is_whole || kind == 'f' : bytes == 1 && is_whole;
}

ValueKind NumberFormat::values() const {
  if (!is_known()) return ValueKind::none;
  return kind != 'f' ? ValueKind::integers : bytes == 8 ? ValueKind::doubles : ValueKind::singles;
}

double NumberFormat::value(const char* at) const {
  char turned[8];
  if (swapped) {
    std::reverse_copy(at, at + bytes, turned);
    at = turned;
  }
  switch (bytes) {
    case 1:
      return kind == 'i' ? stored<std::int8_t>(at) : stored<std::uint8_t>(at);
    case 2:
      return kind == 'f' ? half(at) : kind == 'i' ? stored<std::int16_t>(at) : stored<std::uint16_t>(at);
    case 4:
      return kind == 'f' ? stored<float>(at) : kind == 'i' ? stored<std::int32_t>(at) : stored<std::uint32_t>(at);
    default:
      return kind == 'f' ? stored<double>(at) : kind == 'i' ? stored<std::int64_t>(at) : stored<std::uint64_t>(at);
  }
}

ArrayBytes read_from(const InputFile& file, std::uint64_t base) {
  return [&file, base, buffer = std::make_shared<std::string>()](std::uint64_t offset, std::size_t count) {
    buffer->resize(count);
    if (file.read(base + offset, buffer->data(), count) < count)
      throw Fault(FaultKind::input, "file.changed", fmt::format("{}: became shorter while it was read", file.name()));
    return static_cast<const char*>(buffer->data());
  };
}

ReadArray strided(NumberFormat format, std::vector<std::uint64_t> shape, std::vector<std::uint64_t> steps,
                  std::uint64_t first_byte, ArrayBytes bytes) {
  return [format, shape = std::move(shape), steps = std::move(steps), first_byte, bytes = std::move(bytes)](
             int axis, std::int64_t first, std::int64_t count, double* into) {
    constexpr std::uint64_t most_bytes = 1 << 23;  // at once
    const auto at = static_cast<std::size_t>(axis);
    const bool is_plane = shape.size() > 1;
    const std::uint64_t step = shape.empty() ? 0 : steps[at], step_across = is_plane ? steps[1 - at] : 0,
                        width = is_plane ? shape[1 - at] : 1;
    const auto size = static_cast<std::uint64_t>(format.bytes);
    const std::uint64_t most_rows = std::max<std::uint64_t>(1, most_bytes / std::max<std::uint64_t>(step, 1));
    for (std::uint64_t done = 0; done < static_cast<std::uint64_t>(count);) {
      const std::uint64_t rows = std::min(most_rows, static_cast<std::uint64_t>(count) - done);
      const std::uint64_t begin = first_byte + (static_cast<std::uint64_t>(first) + done) * step;
      const std::uint64_t run = (rows - 1) * step + size;
      const auto copy = [&](const char* from, std::uint64_t column) {
        for (std::uint64_t i = 0; i < rows; ++i) into[(done + i) * width + column] = format.value(from + i * step);
      };
      if (step_across <= step) {  // columns lie within one another
        const char* from = bytes(begin, static_cast<std::size_t>(run + (width - 1) * step_across));
        for (std::uint64_t k = 0; k < width; ++k) copy(from + k * step_across, k);
      } else {
        for (std::uint64_t k = 0; k < width; ++k)
          copy(bytes(begin + k * step_across, static_cast<std::size_t>(run)), k);
      }
      done += rows;
    }
  };
}

std::unique_ptr<SampleSource> open_arrays(std::unique_ptr<InputFile> file, ArrayContents contents,
                                          const OpenOptions& options) {
  return std::make_unique<ArrayFile>(std::move(file), std::move(contents), options);
}

}  // namespace dsp
