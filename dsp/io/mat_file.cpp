#include "dsp/io/mat_file.hpp"

#include <fmt/format.h>
#include <matio.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>

#include "dsp/io/channel_roles.hpp"
#include "dsp/io/found_clock.hpp"
#include "dsp/io/mat_check.hpp"
#include "dsp/io/rows_on_clock.hpp"
#include "dsp/io/table_header.hpp"
#include "dsp/io/table_layout.hpp"
#include "dsp/io/units.hpp"
#include "dsp/memory_limit.hpp"
#include "dsp/names.hpp"

namespace dsp {
namespace {

using File = std::unique_ptr<mat_t, int (*)(mat_t*)>;
using Variable = std::unique_ptr<matvar_t, void (*)(matvar_t*)>;

constexpr std::array class_names{"empty",  "cell",   "struct", "object", "char",     "sparse",
                                 "double", "single", "int8",   "uint8",  "int16",    "uint16",
                                 "int32",  "uint32", "int64",  "uint64", "function", "opaque"};

std::string describe(const matvar_t& variable) {
  std::string size;
  for (int i = 0; i < variable.rank; ++i) size += fmt::format("{}{}", i > 0 ? "x" : "", variable.dims[i]);
  const auto kind = std::min<std::size_t>(static_cast<std::size_t>(variable.class_type), class_names.size() - 1);
  return fmt::format("{} {}{}", size, variable.isComplex ? "complex " : "",
                     variable.isLogical ? "logical" : class_names[kind]);
}

bool is_real(const matvar_t& variable) {
  return variable.class_type >= MAT_C_DOUBLE && variable.class_type <= MAT_C_UINT64 && !variable.isComplex &&
         variable.rank == 2;
}

bool is_integer(const matvar_t& variable) {
  return variable.class_type >= MAT_C_INT8 && !variable.isLogical;
}

// Length of a vector (n x 1 or 1 x n), 0 for anything else.
std::size_t length(const matvar_t& variable) {
  if (!is_real(variable)) return 0;
  return variable.dims[0] == 1 ? variable.dims[1] : variable.dims[1] == 1 ? variable.dims[0] : 0;
}

std::size_t longer_side(const matvar_t& variable) {
  return is_real(variable) ? std::max(variable.dims[0], variable.dims[1]) : 0;
}

template <typename T>
double as_double(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}
// In the order of matio's classes, from double on.
constexpr std::array value_readers{as_double<double>,       as_double<float>,         as_double<std::int8_t>,
                                   as_double<std::uint8_t>, as_double<std::int16_t>,  as_double<std::uint16_t>,
                                   as_double<std::int32_t>, as_double<std::uint32_t>, as_double<std::int64_t>,
                                   as_double<std::uint64_t>};

// How many of its whole numbers have more digits than a double.
template <typename T>
std::size_t num_rounded(const matvar_t& variable) {
  const std::size_t count = variable.dims[0] * variable.dims[1];
  std::size_t rounded = 0;
  for (std::size_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, static_cast<const char*>(variable.data) + i * sizeof value, sizeof value);
    const auto bits = static_cast<std::uint64_t>(value);
    const auto size = std::is_signed_v<T> && static_cast<std::int64_t>(value) < 0 ? ~bits + 1 : bits;
    const int digits = static_cast<int>(std::bit_width(size)) - std::countr_zero(size);
    if (digits > std::numeric_limits<double>::digits) ++rounded;
  }
  return rounded;
}

// One row or column of a variable, which stays in memory in the type it has in the file.
struct Column {
  std::string name, unit;
  std::shared_ptr<const matvar_t> variable;
  const char* first = nullptr;
  std::size_t step = 0;  // bytes from one value to the next
  [[nodiscard]] double operator[](std::size_t i) const {
    return value_readers[static_cast<std::size_t>(variable->class_type - MAT_C_DOUBLE)](first + i * step);
  }
};

// Whether one side of it, and not both, is so long.
bool has_columns(const matvar_t& variable, std::size_t length) {
  return is_real(variable) && length > 1 && (variable.dims[0] == length) != (variable.dims[1] == length);
}

// A field of a structure that is one and not an array of them.
matvar_t* field_of(matvar_t* structure, const char* key) {
  const bool one = structure != nullptr && structure->class_type == MAT_C_STRUCT && structure->data != nullptr &&
                   structure->rank == 2 && structure->dims[0] == 1 && structure->dims[1] == 1;
  return one ? Mat_VarGetStructFieldByName(structure, key, 0) : nullptr;
}

// Simulink's "structure with time": fields time (n x 1) and signals, whose field values is n x k.
struct Simulink {
  const matvar_t *time = nullptr, *values = nullptr;
  explicit Simulink(matvar_t& variable)
      : time(field_of(&variable, "time")), values(field_of(field_of(&variable, "signals"), "values")) {}
  [[nodiscard]] std::size_t frames() const { return time != nullptr && values != nullptr ? length(*time) : 0; }
};

class MatFile : public RowsOnClock {
 public:
  MatFile(std::unique_ptr<InputFile> file, const OpenOptions& options) : file_(std::move(file)) {
    check_mat(*file_, options.max_memory_bytes);
    Mat_LogInitFunc("ardent", [](int, char*) {});  // its messages would go to stderr; ours say more
    File mat(Mat_Open(file_->path().c_str(), MAT_ACC_RDONLY), Mat_Close);
    if (!mat) throw damaged("matio cannot open it");
    const std::size_t num_frames = find_length(*mat);
    Mat_Rewind(mat.get());
    read_variables(*mat, num_frames, options.max_memory_bytes);
    Mat_Rewind(mat.get());
    read_rate(*mat);
    info_.num_frames = static_cast<std::int64_t>(num_frames);
    describe_columns(options);
    check_left_out();
    set_time(options);
  }

 private:
  void finish_reading() override {
    file_->check_unchanged();
    columns_ = {};  // nothing asks for them again
  }

  void read_row(Eigen::RowVectorXd& row) override {
    for (std::size_t i = 0; i < columns_.size(); ++i) row[static_cast<Eigen::Index>(i)] = columns_[i][next_row_];
    ++next_row_;
  }

  // Columns are as long as the longest vector; a shorter one is a parameter. Matrices count where there is no vector.
  static std::size_t find_length(mat_t& mat) {
    std::size_t longest = 0, widest = 0;
    while (const Variable variable{Mat_VarReadNextInfo(&mat), Mat_VarFree}) {
      longest = std::max({longest, length(*variable), Simulink(*variable).frames()});
      widest = std::max(widest, longer_side(*variable));
    }
    return longest > 1 ? longest : widest;
  }

  // Only what becomes columns is read.
  void read_variables(mat_t& mat, std::size_t num_frames, std::size_t max_memory_bytes) {
    while (Variable found{Mat_VarReadNextInfo(&mat), Mat_VarFree}) {
      const std::shared_ptr<matvar_t> variable = std::move(found);
      const std::string name = clean_name(variable->name != nullptr ? variable->name : "");
      const Simulink before(*variable);
      const bool simulink = num_frames > 1 && before.frames() == num_frames && has_columns(*before.values, num_frames);
      if (!simulink && !has_columns(*variable, num_frames)) {
        leave_out(*variable, name, num_frames);
        continue;
      }
      bytes_ += static_cast<double>(Mat_VarGetSize(variable.get()));
      require_memory(file_->name(), bytes_, max_memory_bytes);
      if (Mat_VarReadDataAll(&mat, variable.get()) != 0) throw damaged("cannot read " + name);
      if (simulink)
        add_simulink(variable, name, num_frames);
      else
        add_columns(variable, *variable, name, num_frames);
    }
    if (columns_.empty())
      throw Fault(
          FaultKind::input, "mat.no_variable",
          fmt::format("{}: holds {}; want real vectors (n x 1) of one length", file_->name(),
                      info_.left_out.empty() ? "no variable" : fmt::format("{}", fmt::join(info_.left_out, ", "))));
  }

  // A number by itself that is called as rates and steps are.
  void read_rate(mat_t& mat) {
    while (const Variable variable{Mat_VarReadNextInfo(&mat), Mat_VarFree}) {
      const std::string name = variable->name != nullptr ? variable->name : "";
      const auto is_step = is_step_key(name);
      if (!is_step || !is_real(*variable) || variable->dims[0] != 1 || variable->dims[1] != 1) continue;
      if (Mat_VarReadDataAll(&mat, variable.get()) != 0 || variable->data == nullptr)
        throw damaged("cannot read " + name);
      const double value = value_readers[static_cast<std::size_t>(variable->class_type - MAT_C_DOUBLE)](
          static_cast<const char*>(variable->data));
      if (!(value > 0.0) || !std::isfinite(value)) continue;
      constexpr double rounding = 1e-12;
      rate_hz_ = roundest_rate(*is_step ? 1.0 / value : value, rounding);
      std::erase_if(info_.left_out, [&](const std::string& one) { return one.starts_with(name + " ("); });
    }
  }

  // Those of `values`, which is `variable` or lies in it: one for a vector, for a matrix name_1, name_2, ...
  void add_columns(const std::shared_ptr<const matvar_t>& variable, const matvar_t& values, const std::string& name,
                   std::size_t num_frames) {
    if (values.data == nullptr) throw damaged("cannot read " + name);
    const bool upright = values.dims[0] == num_frames;
    const std::size_t rows = values.dims[0], count = upright ? values.dims[1] : rows;
    const std::size_t size = Mat_SizeOfClass(values.class_type);
    const auto split = split_unit(name);
    for (std::size_t i = 0; i < count; ++i)
      columns_.push_back({count == 1 ? name : fmt::format("{}_{}", split.base, i + 1), split.unit,
                          std::shared_ptr<const matvar_t>(variable, &values),
                          static_cast<const char*>(values.data) + i * size * (upright ? rows : 1),
                          size * (upright ? 1 : rows)});
    if (is_integer(values))
      info_.checks.push_back(
          {"mat.integer", name, CheckStatus::warning, 0.0, 0.0,
           fmt::format("{}: its {} are taken as they are. If they are counts of a converter, say in the sidecar what "
                       "one is worth (full_scale)",
                       file_->name(), describe(values))});
    const std::size_t rounded = values.class_type == MAT_C_INT64    ? num_rounded<std::int64_t>(values)
                                : values.class_type == MAT_C_UINT64 ? num_rounded<std::uint64_t>(values)
                                                                    : 0;
    if (rounded > 0)
      info_.checks.push_back({"mat.rounded", name, CheckStatus::warning, static_cast<double>(rounded), 0.0,
                              fmt::format("{}: {} of its whole numbers have more than 53 bits and lose their last "
                                          "digits. Subtract what they have in common before they are saved",
                                          file_->name(), rounded)});
  }

  // Two structures may share one clock; where they do not, the second is left out.
  void add_simulink(const std::shared_ptr<matvar_t>& variable, const std::string& name, std::size_t num_frames) {
    const Simulink whole(*variable);
    const auto known =
        std::find_if(columns_.begin(), columns_.end(), [](const Column& c) { return is_time_name(c.name); });
    if (known == columns_.end()) {
      add_columns(variable, *whole.time, "time", num_frames);
    } else {
      const Column clock = *known;
      const auto at = columns_.size();
      add_columns(variable, *whole.time, "time", num_frames);
      bool same = true;
      for (std::size_t i = 0; i < num_frames && same; ++i) same = clock[i] == columns_[at][i];
      columns_.resize(at);
      if (!same) return leave_out(*variable, name, num_frames);
    }
    add_columns(variable, *whole.values, name, num_frames);
  }

  void leave_out(const matvar_t& variable, const std::string& name, std::size_t num_frames) {
    const auto own = length(variable);
    info_.left_out.push_back(own > 1 ? fmt::format("{} ({} values, the longest {})", name, own, num_frames)
                                     : fmt::format("{} ({})", name, describe(variable)));
    // A number by itself and a text are no signals.
    std::size_t count = 1;
    for (int i = 0; i < variable.rank; ++i) count *= variable.dims[i];
    lost_ = lost_ || (count > 1 && variable.class_type != MAT_C_CHAR) || variable.class_type == MAT_C_STRUCT ||
            variable.class_type == MAT_C_CELL;
  }

  void describe_columns(const OpenOptions& options) {
    info_.container = "MATLAB v5";
    info_.named = true;
    for (const auto& column : columns_) {
      const auto i = static_cast<int>(info_.columns.size());
      const bool wanted = options.time_column.empty()
                              ? is_time_name(split_unit(column.name).base)
                              : options.time_column == column.name || options.time_column == std::to_string(i + 1);
      if (wanted && info_.time_column < 0) info_.time_column = i;
      info_.columns.push_back(column.name);
      info_.units.push_back(column.unit);
    }
    info_.partial.resize(columns_.size());
    if (!options.time_column.empty() && info_.time_column < 0)
      throw Fault(FaultKind::input, "channel.column",
                  fmt::format("{}: no time column '{}'; there are {}", file_->name(), clean_name(options.time_column),
                              fmt::join(info_.columns, ", ")));
  }

  // The only column that could be a clock and has no signal's name; -1: none.
  [[nodiscard]] int clock_like_column(const OpenOptions& options) const {
    constexpr std::size_t looked_at = 250;
    int found = -1;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const auto is = [&](const std::string& one) { return one == columns_[i].name || one == std::to_string(i + 1); };
      if (!columns_[i].unit.empty() || names_signal(columns_[i].name) ||
          std::any_of(options.signal_columns.begin(), options.signal_columns.end(), is))
        continue;
      std::vector<double> first(std::min(looked_at, static_cast<std::size_t>(info_.num_frames)));
      for (std::size_t k = 0; k < first.size(); ++k) first[k] = columns_[i][k];
      if (!is_clock_like(first)) continue;
      if (found >= 0) return -1;
      found = static_cast<int>(i);
    }
    return found;
  }

  void set_time(const OpenOptions& options) {
    info_.sample_rate_hz = rate_hz_.value_or(0.0);
    const bool is_named = info_.time_column >= 0;
    if (!is_named && !rate_hz_) info_.time_column = clock_like_column(options);
    if (info_.time_column < 0 || !options.with_clock) return;
    require_memory(file_->name(), bytes_ + clock_bytes_per_row * static_cast<double>(info_.num_frames),
                   options.max_memory_bytes);
    const auto at = static_cast<std::size_t>(info_.time_column);
    const auto& unit = options.time_unit.empty() ? info_.units[at] : options.time_unit;
    const double factor = unit.empty() ? 1.0 : find_unit(unit).factor;
    Stamps stamps{{}, 0.0, 1, file_->name()};
    stamps.time_s.resize(static_cast<std::size_t>(info_.num_frames));
    for (std::size_t i = 0; i < stamps.time_s.size(); ++i) stamps.time_s[i] = columns_[at][i] * factor;
    if (columns_[at].variable->class_type == MAT_C_SINGLE)
      stamps.printed_to_s = std::numeric_limits<float>::epsilon() * std::abs(stamps.time_s.back());
    else if (is_integer(*columns_[at].variable))
      stamps.printed_to_s = factor;
    if (!is_named && !is_clock_like(stamps.time_s)) {
      info_.time_column = -1;
      return;
    }
    if (unit.empty()) settle_unit(stamps, info_.time_column + 1, is_named, options.rate_hz, info_.checks);
    set_clock(even_clock(stamps, {.rate_hz = options.rate_hz, .header_rate_hz = rate_hz_, .kind = options.clock}));
  }

  void check_left_out() {
    if (info_.left_out.empty()) return;
    constexpr std::size_t most_named = 20;
    const std::vector<std::string> named(info_.left_out.begin(),
                                         info_.left_out.begin() + std::min(most_named, info_.left_out.size()));
    info_.checks.push_back({"mat.left_out", "", lost_ ? CheckStatus::warning : CheckStatus::note,
                            static_cast<double>(info_.left_out.size()), 0.0,
                            fmt::format("{}: not read, being no real numbers as long as the longest vector: {}{}",
                                        file_->name(), fmt::join(named, ", "),
                                        named.size() < info_.left_out.size()
                                            ? fmt::format(" and {} more", info_.left_out.size() - named.size())
                                            : "")});
  }

  [[nodiscard]] Fault damaged(const std::string& why) const {
    return Fault(FaultKind::input, "mat.damaged", fmt::format("{}: {}", file_->name(), why));
  }

  std::unique_ptr<InputFile> file_;
  std::vector<Column> columns_;
  double bytes_ = 0.0;             // of the variables that were read
  std::optional<double> rate_hz_;  // that a number in it states
  bool lost_ = false;              // whether what is left out may be a signal
  std::size_t next_row_ = 0;
};

}  // namespace

std::unique_ptr<SampleSource> open_mat_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  return std::make_unique<MatFile>(std::move(file), options);
}

}  // namespace dsp
