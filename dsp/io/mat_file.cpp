#include "dsp/io/mat_file.hpp"

#include <fmt/format.h>
#include <matio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "dsp/io/mat_check.hpp"
#include "dsp/io/rows_on_clock.hpp"
#include "dsp/io/table_layout.hpp"
#include "dsp/io/units.hpp"
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
  return fmt::format("{} {}{}", size, variable.isComplex ? "complex " : "", class_names[kind]);
}

bool is_real_float(const matvar_t& variable) {
  return (variable.class_type == MAT_C_DOUBLE || variable.class_type == MAT_C_SINGLE) && !variable.isComplex;
}

// Length of a vector (n x 1 or 1 x n), 0 for anything else.
std::size_t length(const matvar_t& variable) {
  if (!is_real_float(variable) || variable.rank != 2) return 0;
  return variable.dims[0] == 1 ? variable.dims[1] : variable.dims[1] == 1 ? variable.dims[0] : 0;
}

struct Column {
  std::string name;
  std::vector<double> values;
  bool single = false;
};

Column column_of(const matvar_t& variable, std::string name) {
  Column column{std::move(name), std::vector<double>(length(variable)), variable.class_type == MAT_C_SINGLE};
  if (column.single)
    std::copy_n(static_cast<const float*>(variable.data), column.values.size(), column.values.begin());
  else
    std::copy_n(static_cast<const double*>(variable.data), column.values.size(), column.values.begin());
  return column;
}

class MatFile : public RowsOnClock {
 public:
  MatFile(std::unique_ptr<InputFile> file, const OpenOptions& options) : file_(std::move(file)) {
    check_mat(*file_, options.max_memory_bytes);
    read_variables();
    keep_longest();
    describe_columns(options);
    set_time(options);
  }

 private:
  void finish_reading() override { file_->check_unchanged(); }

  void read_row(Eigen::RowVectorXd& row) override {
    for (std::size_t i = 0; i < columns_.size(); ++i) row[static_cast<Eigen::Index>(i)] = columns_[i].values[next_row_];
    ++next_row_;
  }

  void read_variables() {
    Mat_LogInitFunc("ardent", [](int, char*) {});  // its messages would go to stderr; ours say more
    File mat(Mat_Open(file_->path().c_str(), MAT_ACC_RDONLY), Mat_Close);
    if (!mat) throw damaged("matio cannot open it");
    while (true) {
      const Variable variable(Mat_VarReadNextInfo(mat.get()), Mat_VarFree);
      if (!variable) break;
      const std::string name = clean_name(variable->name != nullptr ? variable->name : "");
      const bool vector = length(*variable) > 1, structure = variable->class_type == MAT_C_STRUCT;
      if ((vector || structure) && Mat_VarReadDataAll(mat.get(), variable.get()) != 0)
        throw damaged("cannot read " + name);
      if (vector && variable->data != nullptr)
        columns_.push_back(column_of(*variable, name));
      else if (!structure || !add_simulink(*variable, name))
        info_.left_out.push_back(fmt::format("{} ({})", name, describe(*variable)));
    }
  }

  // Simulink's "structure with time": fields time (n x 1) and signals, whose field values is n x 1.
  bool add_simulink(matvar_t& variable, const std::string& name) {
    const auto field = [](matvar_t* structure, const char* key) -> matvar_t* {
      const bool one = structure != nullptr && structure->class_type == MAT_C_STRUCT && structure->data != nullptr &&
                       structure->rank == 2 && structure->dims[0] == 1 && structure->dims[1] == 1;
      return one ? Mat_VarGetStructFieldByName(structure, key, 0) : nullptr;
    };
    const auto* time = field(&variable, "time");
    const auto* values = field(field(&variable, "signals"), "values");
    if (time == nullptr || values == nullptr || time->data == nullptr || values->data == nullptr) return false;
    if (length(*time) < 2 || length(*values) != length(*time)) return false;
    const auto known =
        std::find_if(columns_.begin(), columns_.end(), [](const Column& c) { return is_time_name(c.name); });
    if (known == columns_.end())
      columns_.push_back(column_of(*time, "time"));
    else if (known->values != column_of(*time, "time").values)
      return false;
    columns_.push_back(column_of(*values, name));
    return true;
  }

  // Columns are what is as long as the longest; a shorter vector is a parameter.
  void keep_longest() {
    std::size_t longest = 0;
    for (const auto& column : columns_) longest = std::max(longest, column.values.size());
    std::erase_if(columns_, [&](const Column& column) {
      const bool shorter = column.values.size() < longest;
      if (shorter)
        info_.left_out.push_back(
            fmt::format("{} ({} values, the longest {})", column.name, column.values.size(), longest));
      return shorter;
    });
    if (columns_.empty())
      throw Fault(
          FaultKind::input, "mat.no_variable",
          fmt::format("{}: holds {}; want real double or single vectors (n x 1) of one length", file_->name(),
                      info_.left_out.empty() ? "no variable" : fmt::format("{}", fmt::join(info_.left_out, ", "))));
    info_.num_frames = static_cast<std::int64_t>(longest);
  }

  void describe_columns(const OpenOptions& options) {
    info_.container = "MATLAB v5";
    info_.named = true;
    for (const auto& column : columns_) {
      const auto split = split_unit(column.name);
      const auto i = static_cast<int>(info_.columns.size());
      const bool wanted = options.time_column.empty()
                              ? is_time_name(split.base)
                              : options.time_column == column.name || options.time_column == std::to_string(i + 1);
      if (wanted && info_.time_column < 0) info_.time_column = i;
      info_.columns.push_back(column.name);
      info_.units.push_back(split.unit);
    }
    info_.partial.resize(columns_.size());
    if (!options.time_column.empty() && info_.time_column < 0)
      throw Fault(FaultKind::input, "channel.column",
                  fmt::format("{}: no time column '{}'; there are {}", file_->name(), clean_name(options.time_column),
                              fmt::join(info_.columns, ", ")));
  }

  void set_time(const OpenOptions& options) {
    if (info_.time_column < 0) return;
    const auto at = static_cast<std::size_t>(info_.time_column);
    const auto& unit = options.time_unit.empty() ? info_.units[at] : options.time_unit;
    Stamps stamps{columns_[at].values, 0.0, 1, file_->name()};
    for (double& time_s : stamps.time_s) time_s *= unit.empty() ? 1.0 : find_unit(unit).factor;
    if (columns_[at].single)
      stamps.printed_to_s = std::numeric_limits<float>::epsilon() * std::abs(stamps.time_s.back());
    set_clock(even_clock(stamps, {.rate_hz = options.rate_hz, .interpolate = options.interpolate}));
  }

  [[nodiscard]] Fault damaged(const std::string& why) const {
    return Fault(FaultKind::input, "mat.damaged", fmt::format("{}: {}", file_->name(), why));
  }

  std::unique_ptr<InputFile> file_;
  std::vector<Column> columns_;
  std::size_t next_row_ = 0;
};

}  // namespace

std::unique_ptr<SampleSource> open_mat_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  return std::make_unique<MatFile>(std::move(file), options);
}

}  // namespace dsp
