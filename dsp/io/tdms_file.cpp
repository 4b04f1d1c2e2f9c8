#include "dsp/io/tdms_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <optional>

#include "dsp/io/array_file.hpp"
#include "dsp/io/table_header.hpp"
#include "dsp/io/table_layout.hpp"
#include "dsp/io/tdms_scale.hpp"
#include "dsp/io/tdms_segments.hpp"
#include "dsp/io/units.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

constexpr std::string_view tdms_mark = "TDSm", tdms_index_mark = "TDSh";

/// Bytes of a file in a window that all channels share: in rows, or in chunks of few, they lie side by side.
class SharedWindow {
 public:
  explicit SharedWindow(const InputFile& file) : file_(file) {}

  /// Valid until the next call. `ahead`: what is behind them is wanted soon.
  const char* bytes(std::uint64_t offset, std::size_t count, bool ahead) {
    constexpr std::size_t window_bytes = std::size_t{1} << 20;
    if (offset < begin_ || offset + count > begin_ + window_.size()) {
      begin_ = offset;
      window_ = file_.text(offset, ahead ? std::max(count, window_bytes) : count);
      if (window_.size() < count)
        throw Fault(FaultKind::input, "file.changed",
                    fmt::format("{}: became shorter while it was read", file_.name()));
    }
    return window_.data() + (offset - begin_);
  }

 private:
  const InputFile& file_;
  std::uint64_t begin_ = 0;
  std::string window_;
};

/// The values of a channel, from wherever they are.
class ChannelValues {
 public:
  ChannelValues(std::shared_ptr<SharedWindow> window, TdmsObject object, TdmsScale scale)
      : window_(std::move(window)),
        runs_(std::move(object.runs)),
        type_(*find_tdms_type(object.type)),
        scale_(std::move(scale)) {
    if (type_.format.bytes == 0) first_second_ = stamp_at(0).seconds;
  }

  void read(std::int64_t first, std::int64_t count, double* into) const {
    constexpr std::uint64_t most_bytes = 1 << 20;  // at once
    auto at = static_cast<std::uint64_t>(first), left = static_cast<std::uint64_t>(count);
    while (left > 0) {
      const Place place = place_of(at);
      const TdmsRun& run = *place.run;
      const std::uint64_t rows =
          std::min({left, place.num_left, std::max<std::uint64_t>(1, most_bytes / run.row_bytes)});
      // Rows as they are, so that the next channel finds them in the window, if they are not of absurd width.
      const bool is_alone = run.row_bytes > most_bytes;
      const std::uint64_t begin = is_alone ? run.offset_in_row : 0;
      const char* bytes =
          window_->bytes(place.offset + begin, is_alone ? type_.bytes : rows * run.row_bytes, rows < left && !is_alone);
      for (std::uint64_t i = 0; i < rows; ++i, ++into)
        *into = value(bytes + i * run.row_bytes + run.offset_in_row - begin, run.is_big);
      at += rows;
      left -= rows;
    }
  }

 private:
  struct Place {
    const TdmsRun* run;
    std::uint64_t offset, num_left;  // of the row, and rows behind it in its chunk
  };

  [[nodiscard]] Place place_of(std::uint64_t value) const {
    const auto behind = std::upper_bound(runs_.begin(), runs_.end(), value,
                                         [](std::uint64_t at, const TdmsRun& run) { return at < run.first_value; });
    const TdmsRun& run = *std::prev(behind);
    const std::uint64_t in_run = value - run.first_value, chunk = in_run / run.count, row = in_run % run.count;
    return {&run,
            run.offset + chunk / run.num_chunks * run.segment_step + chunk % run.num_chunks * run.chunk_step +
                row * run.row_bytes,
            run.count - row};
  }

  [[nodiscard]] double value(const char* at, bool is_big) const {
    if (type_.format.bytes == 0) {
      const TdmsTime stamp = tdms_time(at, is_big);
      // As seconds of a damaged file may differ by more than an integer holds.
      const auto difference = static_cast<std::uint64_t>(stamp.seconds) - static_cast<std::uint64_t>(first_second_);
      return static_cast<double>(static_cast<std::int64_t>(difference)) + stamp.fraction;
    }
    NumberFormat format = type_.format;
    format.swapped = is_big == (std::endian::native == std::endian::little);
    return scale_(format.value(at));
  }

  [[nodiscard]] TdmsTime stamp_at(std::uint64_t value) const {
    const Place place = place_of(value);
    return tdms_time(window_->bytes(place.offset + place.run->offset_in_row, type_.bytes, false), place.run->is_big);
  }

  std::shared_ptr<SharedWindow> window_;
  std::vector<TdmsRun> runs_;
  TdmsType type_;
  TdmsScale scale_;
  std::int64_t first_second_ = 0;  // stamps count from it: seconds since 1904 would leave a double half a microsecond
};

/// What a channel says of its clock.
struct WaveformClock {
  double rate_hz = 0.0;  // 0: nothing
  std::optional<TdmsTime> start{};
  double offset_s = 0.0;
  [[nodiscard]] double later_s(const WaveformClock& first) const {
    const double begun_s = start && first.start ? static_cast<double>(start->seconds - first.start->seconds) +
                                                      (start->fraction - first.start->fraction)
                                                : 0.0;
    return begun_s + (offset_s - first.offset_s);
  }
};

class TdmsArrays {
 public:
  TdmsArrays(const InputFile& file, const OpenOptions& options)
      : file_(file), found_(read_tdms_segments(file, options)), window_(std::make_shared<SharedWindow>(file)) {}

  ArrayContents contents() {
    ArrayContents contents{.container = "TDMS", .prefix = "tdms"};
    if (!found_.cut.empty())
      contents.checks.push_back({"container.truncated", "", CheckStatus::warning, 0.0, 0.0,
                                 fmt::format("{}: {}; what is whole before it was read", file_.name(), found_.cut)});
    for (const TdmsObject& object : found_.objects) {
      if (!object.runs.empty()) longest_ = std::max(longest_, object.num_values);
      if (!object.is_channel) groups_[object.group] = &object;
    }
    for (std::size_t i = 0; i < found_.objects.size(); ++i) add(found_.objects[i], contents);
    return contents;
  }

 private:
  void add(TdmsObject& object, ArrayContents& contents) {
    if (!object.is_channel) return;
    if (object.num_values == 0) {
      contents.left_out.push_back(fmt::format("{} (no values)", clean_name(object.name)));
      return;
    }
    const TdmsType& type = *find_tdms_type(object.type);
    FileArray array{.group = object.group + "/",
                    .name = object.name,
                    .unit = tdms_text(object, "unit_string"),
                    .kind = type.kind,
                    .shape = {static_cast<std::int64_t>(std::min<std::uint64_t>(object.num_values, INT64_MAX))},
                    .values = type.format.values()};
    const bool is_stamps = type.kind == "time stamps";
    if (is_stamps) array.values = ValueKind::doubles, array.unit = "s";
    TdmsScale scale(holders(object));
    if (scale.is_needed()) array.values = ValueKind::doubles;
    if (object.has_several_types) leave_out(array, "values of several types");
    if (!scale.unknown().empty())
      leave_out(array, fmt::format("values to be scaled by {}: save them scaled", clean_name(scale.unknown())));
    if (array.values != ValueKind::none && !is_stamps) settle_clock(object, array);
    if (array.values != ValueKind::none) {
      const auto values = std::make_shared<const ChannelValues>(window_, std::move(object), std::move(scale));
      array.read = [values](int, std::int64_t first, std::int64_t count, double* into) {
        values->read(first, count, into);
      };
    }
    contents.arrays.push_back(std::move(array));
  }

  static void leave_out(FileArray& array, std::string why) {
    array.values = ValueKind::none;
    array.kind = std::move(why);
  }

  // The object, its group and the file: properties of one hold for what is in it.
  [[nodiscard]] std::vector<const TdmsObject*> holders(const TdmsObject& object) const {
    std::vector<const TdmsObject*> all{&object};
    for (const std::string& group : {object.group, std::string()})
      if (const auto found = groups_.find(group); found != groups_.end()) all.push_back(found->second);
    return all;
  }

  // Those of the greatest length are on one clock, the first's.
  void settle_clock(const TdmsObject& object, FileArray& array) {
    const WaveformClock clock = clock_of(object);
    array.rate_hz = clock.rate_hz;
    if (object.num_values != longest_ || clock.rate_hz == 0.0) return;
    if (!first_) first_ = clock;
    const double later_s = clock.later_s(*first_);
    if (clock.rate_hz != first_->rate_hz)
      leave_out(array, fmt::format("values at {:.6g} Hz, others at {:.6g}", clock.rate_hz, first_->rate_hz));
    else if (constexpr double most_steps = 0.5; std::abs(later_s) * clock.rate_hz > most_steps)
      leave_out(array,
                fmt::format("values that begin {:.6g} s {}", std::abs(later_s), later_s > 0 ? "later" : "earlier"));
  }

  [[nodiscard]] WaveformClock clock_of(const TdmsObject& object) const {
    WaveformClock clock;
    constexpr double rounding = 1e-12;
    const std::string unit = tdms_text(object, "wf_xunit_string");
    const double factor = is_unit(unit) && find_unit(unit).si == "s" ? find_unit(unit).factor : 1.0;
    const double step_s = factor * tdms_number(object, "wf_increment").value_or(0.0);
    if (is_positive(step_s)) clock.rate_hz = roundest_rate(1.0 / step_s, rounding);
    for (const TdmsObject* holder : holders(object))
      for (const auto& [name, value] : holder->properties)
        if (const auto rate = rate_name(name); rate && clock.rate_hz == 0.0)
          if (const double rate_hz = rate->rate_hz(tdms_number(*holder, name).value_or(0.0)); rate_hz > 0.0)
            clock.rate_hz = roundest_rate(rate_hz, rounding);
    const auto start = object.properties.find("wf_start_time");
    if (start != object.properties.end() && std::holds_alternative<TdmsTime>(start->second))
      clock.start = std::get<TdmsTime>(start->second);
    clock.offset_s = factor * tdms_number(object, "wf_start_offset").value_or(0.0);
    return clock;
  }

  static bool is_positive(double number) {
    return number > 0.0 && std::isnormal(number) && std::isnormal(1.0 / number);
  }

  const InputFile& file_;
  TdmsContents found_;
  std::shared_ptr<SharedWindow> window_;
  std::map<std::string, const TdmsObject*> groups_;  // and the file, whose name is empty
  std::uint64_t longest_ = 0;
  std::optional<WaveformClock> first_{};
};

}  // namespace

bool is_tdms(std::string_view head) {
  return head.starts_with(tdms_mark) || head.starts_with(tdms_index_mark);
}

std::unique_ptr<SampleSource> open_tdms_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  if (file->text(0, tdms_index_mark.size()) == tdms_index_mark)
    throw Fault(FaultKind::input, "container.unsupported",
                fmt::format("{}: is the index of a TDMS file and holds no samples. Name the file it belongs to, "
                            "which ends in .tdms",
                            file->name()));
  ArrayContents contents = TdmsArrays(*file, options).contents();
  return open_arrays(std::move(file), std::move(contents), options);
}

}  // namespace dsp
