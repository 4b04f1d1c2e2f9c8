#include "dsp/io/mat_file.hpp"

#include <fmt/format.h>
#include <matio.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>

#include "dsp/io/array_file.hpp"
#include "dsp/io/mat_check.hpp"

namespace dsp {
namespace {

constexpr std::array class_names{"empty",  "cell",   "struct", "object", "char",     "sparse",
                                 "double", "single", "int8",   "uint8",  "int16",    "uint16",
                                 "int32",  "uint32", "int64",  "uint64", "function", "opaque"};

std::string kind_of(const matvar_t& variable) {
  const auto kind = std::min<std::size_t>(static_cast<std::size_t>(variable.class_type), class_names.size() - 1);
  return fmt::format("{}{}", variable.isComplex ? "complex " : "", variable.isLogical ? "logical" : class_names[kind]);
}

ValueKind values_of(const matvar_t& variable) {
  if (variable.class_type < MAT_C_DOUBLE || variable.class_type > MAT_C_UINT64 || variable.isComplex)
    return ValueKind::none;
  if (variable.class_type <= MAT_C_SINGLE)
    return variable.class_type == MAT_C_DOUBLE ? ValueKind::doubles : ValueKind::singles;
  return ValueKind::integers;
}

// matio turns bytes round itself.
NumberFormat format_of(const matvar_t& variable) {
  const int bytes = static_cast<int>(Mat_SizeOfClass(variable.class_type));
  if (variable.class_type <= MAT_C_SINGLE) return {'f', bytes};
  return {(variable.class_type - MAT_C_INT8) % 2 == 0 ? 'i' : 'u', bytes};
}

// How many of its whole numbers have more digits than a double.
template <typename T>
std::size_t num_rounded(const matvar_t& variable, std::size_t count) {
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

/// An open file, and what is in it as arrays: variables, and what lies in structures and cells.
class MatArrays : public std::enable_shared_from_this<MatArrays> {
 public:
  explicit MatArrays(const InputFile& file)
      : name_(file.name()), mat_(Mat_Open(file.path().c_str(), MAT_ACC_RDONLY), Mat_Close) {
    if (!mat_) throw damaged("matio cannot open it");
  }

  ArrayContents contents(std::string container) {
    contents_ = {.container = std::move(container), .prefix = "mat"};
    while (matvar_t* found = Mat_VarReadNextInfo(mat_.get())) {
      const auto variable = std::make_shared<Variable>(found);
      add(variable, *found, "", found->name != nullptr ? found->name : "", 0);
    }
    return std::move(contents_);
  }

 private:
  struct Variable {
    explicit Variable(matvar_t* read) : whole(read, Mat_VarFree) {}
    std::unique_ptr<matvar_t, void (*)(matvar_t*)> whole;
    bool is_loaded = false;
  };

  [[nodiscard]] Fault damaged(const std::string& why) const {
    return Fault(FaultKind::input, "mat.damaged", fmt::format("{}: {}", name_, why));
  }

  [[nodiscard]] static bool is_one(const matvar_t& variable) {
    return variable.rank == 2 && variable.dims[0] == 1 && variable.dims[1] == 1;
  }

  // Simulink's "structure with time": its signal is called like the structure.
  [[nodiscard]] static matvar_t* simulink_values(matvar_t& variable) {
    matvar_t* signals = Mat_VarGetStructFieldByName(&variable, "signals", 0);
    const bool has = signals != nullptr && signals->class_type == MAT_C_STRUCT && signals->data != nullptr &&
                     is_one(*signals) && Mat_VarGetStructFieldByName(&variable, "time", 0) != nullptr;
    return has ? Mat_VarGetStructFieldByName(signals, "values", 0) : nullptr;
  }

  // NOLINTNEXTLINE(misc-no-recursion): no deeper than the check before allows
  void add(const std::shared_ptr<Variable>& variable, matvar_t& part, const std::string& group, const std::string& name,
           int depth) {
    constexpr std::size_t most_arrays = 10'000;
    constexpr int deepest = 8;
    if (contents_.arrays.size() > most_arrays || depth > deepest) return;
    if (part.class_type == MAT_C_STRUCT && part.data != nullptr && is_one(part) && Mat_VarGetNumberOfFields(&part) > 0)
      return add_fields(variable, part, group + name, depth);
    if (part.class_type == MAT_C_CELL && part.data != nullptr && holds_arrays(part))
      return add_cells(variable, part, group, name, depth);
    FileArray array{.group = group, .name = name, .kind = kind_of(part), .values = values_of(part)};
    for (int i = 0; i < part.rank; ++i) array.shape.push_back(static_cast<std::int64_t>(part.dims[i]));
    if (array.values != ValueKind::none) make_readable(array, variable, part);
    if (part.class_type == MAT_C_CHAR || part.class_type == MAT_C_CELL)
      array.read_texts = [self = shared_from_this(), variable, &part] { return self->texts_of(*variable, part); };
    contents_.arrays.push_back(std::move(array));
  }

  void add_fields(const std::shared_ptr<Variable>& variable, matvar_t& part, const std::string& path, int depth) {
    matvar_t* const values = simulink_values(part);
    char* const* names = Mat_VarGetStructFieldnames(&part);
    for (unsigned i = 0; i < Mat_VarGetNumberOfFields(&part); ++i) {
      matvar_t* field = Mat_VarGetStructFieldByIndex(&part, i, 0);
      if (field == nullptr || names[i] == nullptr) continue;
      const bool is_signal = values != nullptr && std::string_view(names[i]) == "signals";
      if (is_signal)
        add(variable, *values, path + ".", path, depth + 1);
      else
        add(variable, *field, path + ".", names[i], depth + 1);
    }
  }

  // Few, and of more than a number each.
  [[nodiscard]] static bool holds_arrays(matvar_t& part) {
    constexpr std::size_t most_cells = 1000;
    std::size_t count = 1;
    for (int i = 0; i < part.rank; ++i) count *= part.dims[i];
    if (count == 0 || count > most_cells) return false;
    for (std::size_t i = 0; i < count; ++i) {
      const matvar_t* cell = Mat_VarGetCell(&part, static_cast<int>(i));
      if (cell != nullptr && cell->rank == 2 && cell->dims[0] * cell->dims[1] > 1 &&
          values_of(*cell) != ValueKind::none)
        return true;
    }
    return false;
  }

  void add_cells(const std::shared_ptr<Variable>& variable, matvar_t& part, const std::string& group,
                 const std::string& name, int depth) {
    std::size_t count = 1;
    for (int i = 0; i < part.rank; ++i) count *= part.dims[i];
    for (std::size_t i = 0; i < count; ++i)
      if (matvar_t* cell = Mat_VarGetCell(&part, static_cast<int>(i)); cell != nullptr)
        add(variable, *cell, group, fmt::format("{}_{}", name, i + 1), depth + 1);
  }

  void make_readable(FileArray& array, const std::shared_ptr<Variable>& variable, matvar_t& part) {
    array.bytes = static_cast<double>(Mat_SizeOfClass(part.class_type));
    std::vector<std::uint64_t> shape, steps;
    std::uint64_t step = Mat_SizeOfClass(part.class_type);
    for (int i = 0; i < part.rank; ++i) {
      array.bytes *= static_cast<double>(part.dims[i]);
      if (part.dims[i] != 1) {
        shape.push_back(part.dims[i]);
        steps.push_back(step);
      }
      if (__builtin_mul_overflow(step, part.dims[i], &step)) return void(array.values = ValueKind::none);
    }
    array.load = [self = shared_from_this(), variable, &part, size = step] { self->load(*variable, part, size); };
    array.read = strided(format_of(part), shape, steps, 0, [variable, &part](std::uint64_t offset, std::size_t) {
      return static_cast<const char*>(part.data) + offset;
    });
    const std::size_t count = step / Mat_SizeOfClass(part.class_type);
    if (part.class_type == MAT_C_INT64)
      array.num_rounded = [variable, &part, count] { return num_rounded<std::int64_t>(part, count); };
    else if (part.class_type == MAT_C_UINT64)
      array.num_rounded = [variable, &part, count] { return num_rounded<std::uint64_t>(part, count); };
  }

  // Of a line of characters, or of a cell of such; empty of anything else.
  [[nodiscard]] std::vector<std::string> texts_of(Variable& variable, matvar_t& part) {
    constexpr std::size_t most = 1000;
    std::size_t count = 1;
    for (int i = 0; i < part.rank && count <= most; ++i) count *= part.dims[i];
    if (part.class_type == MAT_C_CELL && (count == 0 || count > most)) return {};
    if (!is_read(variable)) return {};
    if (part.class_type == MAT_C_CHAR) return text_of(part) ? std::vector{*text_of(part)} : std::vector<std::string>();
    std::vector<std::string> texts;
    for (std::size_t i = 0; part.data != nullptr && i < count; ++i) {
      const matvar_t* cell = Mat_VarGetCell(&part, static_cast<int>(i));
      const auto text = cell == nullptr ? std::nullopt : text_of(*cell);
      if (!text) return {};
      texts.push_back(*text);
    }
    return texts;
  }

  [[nodiscard]] static std::optional<std::string> text_of(const matvar_t& line) {
    constexpr std::size_t longest = 1000;
    if (line.class_type != MAT_C_CHAR || line.rank != 2 || line.dims[0] > 1 || line.dims[1] > longest)
      return std::nullopt;
    const std::size_t count = line.dims[0] * line.dims[1];
    if (count == 0) return "";
    const bool is_wide = line.data_type == MAT_T_UINT16 || line.data_type == MAT_T_UTF16;
    if (line.data == nullptr || line.nbytes < count * (is_wide ? 2 : 1)) return std::nullopt;
    std::string text;
    for (std::size_t i = 0; i < count; ++i) {
      std::uint16_t code = 0;
      if (is_wide)
        std::memcpy(&code, static_cast<const char*>(line.data) + 2 * i, 2);
      else
        code = static_cast<const unsigned char*>(line.data)[i];
      if (code < 0x80 || line.data_type == MAT_T_UTF8) {
        text += static_cast<char>(code);
      } else {
        if (code >= 0x800) text += static_cast<char>(0xe0 | (code >> 12));
        text += static_cast<char>(code >= 0x800 ? 0x80 | ((code >> 6) & 0x3f) : 0xc0 | (code >> 6));
        text += static_cast<char>(0x80 | (code & 0x3f));
      }
    }
    return text;
  }

  [[nodiscard]] bool is_read(Variable& variable) {
    if (!variable.is_loaded && Mat_VarReadDataAll(mat_.get(), variable.whole.get()) != 0) return false;
    return variable.is_loaded = true;
  }

  void load(Variable& variable, const matvar_t& part, std::uint64_t size) {
    const char* name = variable.whole->name;
    if (!is_read(variable)) throw damaged(fmt::format("cannot read {}", name != nullptr ? name : ""));
    if (size > 0 && (part.data == nullptr || part.nbytes < size)) throw damaged("a variable has no data");
  }

  std::string name_;
  std::unique_ptr<mat_t, int (*)(mat_t*)> mat_;
  ArrayContents contents_;
};

}  // namespace

std::unique_ptr<SampleSource> open_mat_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  const bool is_level_4 = check_mat(*file, options.max_memory_bytes) == MatLevel::four;
  Mat_LogInitFunc("ardent", [](int, char*) {});  // its messages would go to stderr; ours say more
  ArrayContents contents = std::make_shared<MatArrays>(*file)->contents(is_level_4 ? "MATLAB v4" : "MATLAB v5");
  return open_arrays(std::move(file), std::move(contents), options);
}

}  // namespace dsp
