#include "dsp/io/hdf5_file.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "dsp/io/array_file.hpp"
#include "dsp/io/survives.hpp"
#include "dsp/io/table_header.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/memory_limit.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

constexpr std::string_view hdf5_magic("\x89HDF\r\n\x1a\n", 8);
constexpr std::size_t matlab_block = 512;

/// An identifier of the library, closed in the end.
class Hdf5Id {
 public:
  Hdf5Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Hdf5Id(const Hdf5Id&) = delete;
  Hdf5Id& operator=(const Hdf5Id&) = delete;
  ~Hdf5Id() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor): as the library's functions take it
  [[nodiscard]] bool is_open() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// What the library says of the last failure, from where it began.
std::string reason_of_failure() {
  std::string reason;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned, const H5E_error2_t* error, void* into) -> herr_t {
        auto& text = *static_cast<std::string*>(into);
        if (text.empty() && error->desc != nullptr) text = error->desc;
        return 0;
      },
      &reason);
  return clean_name(reason);
}

std::optional<std::string> text_attribute(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return std::nullopt;
  const Hdf5Id attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  const Hdf5Id type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  if (!attribute.is_open() || H5Tget_class(type) != H5T_STRING || H5Sget_simple_extent_npoints(space) != 1)
    return std::nullopt;
  if (H5Tis_variable_str(type) > 0) {
    char* text = nullptr;
    const Hdf5Id memory(H5Tget_native_type(type, H5T_DIR_ASCEND), H5Tclose);
    if (H5Aread(attribute, memory, static_cast<void*>(&text)) < 0 || text == nullptr) return std::nullopt;
    std::string found = text;
    H5free_memory(text);
    return found;
  }
  constexpr std::size_t longest = 1 << 16;
  const std::size_t size = H5Tget_size(type);
  if (size == 0 || size > longest) return std::nullopt;
  std::string text(size, '\0');
  if (H5Aread(attribute, type, text.data()) < 0) return std::nullopt;
  text.resize(std::min(text.find('\0'), text.size()));
  return text;
}

/// Texts of an attribute or a dataset, a few; empty where it has none.
template <class Read>
std::vector<std::string> texts_in(const Hdf5Id& type, const Hdf5Id& space, Read&& read) {
  constexpr hssize_t most = 1000;
  constexpr std::size_t longest = 1 << 12;
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  if (H5Tget_class(type) != H5T_STRING || count < 1 || count > most) return {};
  std::vector<std::string> texts;
  if (H5Tis_variable_str(type) > 0) {
    std::vector<char*> pointers(static_cast<std::size_t>(count), nullptr);
    const Hdf5Id memory(H5Tget_native_type(type, H5T_DIR_ASCEND), H5Tclose);
    const bool is_read = read(memory, static_cast<void*>(pointers.data())) >= 0;
    for (char* text : pointers) {
      if (is_read) texts.emplace_back(text != nullptr ? text : "");
      H5free_memory(text);
    }
    return texts;
  }
  const std::size_t size = H5Tget_size(type);
  if (size == 0 || size > longest) return {};
  std::string all(size * static_cast<std::size_t>(count), '\0');
  if (read(type, static_cast<void*>(all.data())) < 0) return {};
  for (std::size_t at = 0; at < all.size(); at += size) {
    const std::string text = all.substr(at, size);
    texts.push_back(text.substr(0, std::min(text.find('\0'), text.find_last_not_of(' ') + 1)));
  }
  return texts;
}

bool is_number_type(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  return kind == H5T_INTEGER || kind == H5T_FLOAT;
}

std::vector<std::string> attribute_names(hid_t object) {
  std::vector<std::string> names;
  H5Aiterate2(
      object, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr,
      [](hid_t, const char* name, const H5A_info_t*, void* into) -> herr_t {
        constexpr std::size_t most = 1000;
        auto& all = *static_cast<std::vector<std::string>*>(into);
        all.emplace_back(name);
        return all.size() < most ? 0 : 1;
      },
      &names);
  return names;
}

// The rate that attributes called as rates and steps are state; 0: none.
double rate_attribute(hid_t object) {
  for (const std::string& name : attribute_names(object)) {
    const auto rate = rate_name(name);
    if (!rate) continue;
    const Hdf5Id attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose);
    const Hdf5Id type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
    double value = 0.0;
    if (!attribute.is_open() || !is_number_type(type) || H5Sget_simple_extent_npoints(space) != 1 ||
        H5Aread(attribute, H5T_NATIVE_DOUBLE, &value) < 0)
      continue;
    if (const double rate_hz = rate->rate_hz(value); rate_hz > 0.0) return rate_hz;
  }
  return 0.0;
}

/// A dataset or a member of a compound one, as numbers.
struct Dataset {
  std::shared_ptr<Hdf5Id> file, id;
  std::string file_name, path, member;
  bool has_path = true;  // else a cell refers to it
  std::vector<hsize_t> dims;
  std::vector<std::size_t> long_axes;  // those longer than 1, in the order of FileArray::shape

  [[noreturn]] void refuse() const {
    throw Fault(FaultKind::input, "hdf5.damaged",
                fmt::format("{}: '{}' cannot be read ({}). Copy the file from its source again, or save it without "
                            "packing",
                            file_name, clean_name(path), reason_of_failure()));
  }

  void read(int axis, std::int64_t first, std::int64_t count, double* into) const {
    std::vector<hsize_t> start(dims.size(), 0), size = dims;
    const bool is_plane = long_axes.size() > 1;
    const std::size_t along = long_axes.empty() ? 0 : long_axes[static_cast<std::size_t>(axis)],
                      across = is_plane ? long_axes[1 - static_cast<std::size_t>(axis)] : 0;
    const std::size_t width = is_plane ? static_cast<std::size_t>(dims[across]) : 1,
                      rows = static_cast<std::size_t>(count);
    if (!long_axes.empty()) {
      start[along] = static_cast<hsize_t>(first);
      size[along] = static_cast<hsize_t>(count);
    }
    const Hdf5Id space(H5Dget_space(*id), H5Sclose);
    const hsize_t total = rows * width;
    const Hdf5Id memory(H5Screate_simple(1, &total, nullptr), H5Sclose);
    if (!dims.empty() && H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr) < 0)
      refuse();
    std::unique_ptr<Hdf5Id> compound;
    if (!member.empty()) {
      compound = std::make_unique<Hdf5Id>(H5Tcreate(H5T_COMPOUND, sizeof(double)), H5Tclose);
      H5Tinsert(*compound, member.c_str(), 0, H5T_NATIVE_DOUBLE);
    }
    const hid_t type = compound ? static_cast<hid_t>(*compound) : H5T_NATIVE_DOUBLE;
    const bool in_rows = !is_plane || along < across;
    std::vector<double> values(in_rows ? 0 : rows * width);
    if (H5Dread(*id, type, memory, space, H5P_DEFAULT, in_rows ? into : values.data()) < 0) refuse();
    for (std::size_t i = 0; !in_rows && i < rows; ++i)
      for (std::size_t k = 0; k < width; ++k) into[i * width + k] = values[k * rows + i];
  }
};

constexpr std::array matlab_numbers{"double", "single", "logical", "int8",  "uint8", "int16",
                                    "uint16", "int32",  "uint32",  "int64", "uint64"};

/// What is in a file, as arrays.
class Hdf5Arrays {
 public:
  Hdf5Arrays(const InputFile& file, std::size_t max_memory_bytes)
      : name_(file.name()), bytes_(file.size()), max_memory_bytes_(max_memory_bytes) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // its messages would go to stderr; ours say more
    const Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_file_locking(access, 0, 1);
    // The usual driver follows links to a name, which what is open by its descriptor alone does not have.
    std::error_code unknown;
    if (std::filesystem::is_symlink(file.path(), unknown)) H5Pset_fapl_stdio(access);
    H5Pset_fclose_degree(access, H5F_CLOSE_SEMI);
    file_ = std::make_shared<Hdf5Id>(H5Fopen(file.path().c_str(), H5F_ACC_RDONLY, access), H5Fclose);
    if (!file_->is_open()) {
      const std::string reason = reason_of_failure();
      throw Fault(FaultKind::input, reason.find("truncated") != reason.npos ? "container.truncated" : "hdf5.damaged",
                  fmt::format("{}: HDF5 cannot open it ({}). Copy the file from its source again", name_, reason));
    }
    is_matlab_ = file.text(0, 10) == "MATLAB 7.3";
  }

  ArrayContents contents() {
    contents_ = {.container = is_matlab_ ? "MATLAB v7.3" : "HDF5", .prefix = is_matlab_ ? "mat" : "hdf5"};
    contents_.rate_hz = rate_of_groups();
    std::vector<std::string> paths;
    const auto note = [](hid_t, const char* path, const H5O_info_t* info, void* into) -> herr_t {
      constexpr std::size_t most = 10'000;
      auto& all = *static_cast<std::vector<std::string>*>(into);
      const bool is_inner = *path == '#';  // what MATLAB's cells and objects refer to
      if (info->type == H5O_TYPE_DATASET && !is_inner) all.emplace_back(path);
      return all.size() < most ? 0 : 1;
    };
    if (H5Ovisit2(*file_, H5_INDEX_NAME, H5_ITER_INC, note, &paths, H5O_INFO_BASIC) < 0)
      throw Fault(FaultKind::input, "hdf5.damaged",
                  fmt::format("{}: what is in it cannot be listed ({}). Copy the file from its source again", name_,
                              reason_of_failure()));
    for (const std::string& path : paths) add(open(path), path);
    return std::move(contents_);
  }

 private:
  // Of the file, or the only one that its groups state.
  [[nodiscard]] double rate_of_groups() const {
    if (const double rate_hz = rate_attribute(*file_); rate_hz > 0.0) return rate_hz;
    std::vector<double> rates_hz;
    const auto note = [](hid_t file, const char* path, const H5O_info_t* info, void* into) -> herr_t {
      constexpr std::size_t most = 1000;
      auto& all = *static_cast<std::vector<double>*>(into);
      if (info->type != H5O_TYPE_GROUP) return 0;
      const Hdf5Id group(H5Oopen(file, path, H5P_DEFAULT), H5Oclose);
      const double rate_hz = group.is_open() ? rate_attribute(group) : 0.0;
      if (rate_hz > 0.0 && std::find(all.begin(), all.end(), rate_hz) == all.end()) all.push_back(rate_hz);
      return all.size() < most ? 0 : 1;
    };
    if (H5Ovisit2(*file_, H5_INDEX_NAME, H5_ITER_INC, note, &rates_hz, H5O_INFO_BASIC) < 0) return 0.0;
    return rates_hz.size() == 1 ? rates_hz.front() : 0.0;
  }

  // Of the group that a dataset is in, or of one around it.
  [[nodiscard]] double rate_around(const std::string& path) const {
    for (auto mark = path.rfind('/'); mark != path.npos && mark > 0; mark = path.rfind('/', mark - 1)) {
      const Hdf5Id group(H5Oopen(*file_, path.substr(0, mark).c_str(), H5P_DEFAULT), H5Oclose);
      if (const double rate_hz = group.is_open() ? rate_attribute(group) : 0.0; rate_hz > 0.0) return rate_hz;
    }
    return 0.0;
  }

  [[nodiscard]] std::shared_ptr<Hdf5Id> open(const std::string& path) const {
    return std::make_shared<Hdf5Id>(H5Dopen2(*file_, path.c_str(), H5P_DEFAULT), H5Dclose);
  }

  // NOLINTNEXTLINE(misc-no-recursion): cells within cells, not deeper than that
  void add(std::shared_ptr<Hdf5Id> id, const std::string& path, bool is_cell = false) {
    Dataset dataset{.file = file_, .id = std::move(id), .file_name = name_, .path = path, .has_path = !is_cell};
    if (!dataset.id->is_open()) dataset.refuse();
    FileArray array = described(dataset);
    const Hdf5Id type(H5Dget_type(*dataset.id), H5Tclose);
    const std::string matlab = text_attribute(*dataset.id, "MATLAB_class").value_or("");
    if (array.kind.empty() && H5Tget_class(type) == H5T_COMPOUND) return add_members(array, dataset, type);
    if (array.kind.empty() && matlab == "cell" && H5Tget_class(type) == H5T_REFERENCE && !is_cell &&
        add_cells(dataset, path))
      return;
    if (array.kind.empty()) set_kind(array, type, matlab);
    if (array.kind == "text")
      array.texts = texts_in(type, Hdf5Id(H5Dget_space(*dataset.id), H5Sclose), [&](hid_t memory, void* into) {
        return H5Dread(*dataset.id, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, into);
      });
    if (array.values != ValueKind::none) {
      add_lists_of(*dataset.id, array);
      make_readable(array, std::move(dataset));
    }
    contents_.arrays.push_back(std::move(array));
  }

  // Attributes that are lists of texts, as columns' names and units are.
  void add_lists_of(hid_t dataset, const FileArray& array) {
    for (const std::string& name : attribute_names(dataset)) {
      const Hdf5Id attribute(H5Aopen(dataset, name.c_str(), H5P_DEFAULT), H5Aclose);
      if (!attribute.is_open()) continue;
      const Hdf5Id type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
      auto texts = texts_in(type, space, [&](hid_t memory, void* into) { return H5Aread(attribute, memory, into); });
      if (texts.size() > 1)
        contents_.arrays.push_back({.group = array.group + array.name + "/",
                                    .name = name,
                                    .kind = "text",
                                    .shape = {static_cast<std::int64_t>(texts.size())},
                                    .texts = std::move(texts)});
    }
  }

  // Its place and shape; `kind` says why where it cannot be read whatever it holds.
  [[nodiscard]] FileArray described(Dataset& dataset) const {
    FileArray array;
    std::string path = dataset.path;
    if (is_matlab_) std::replace(path.begin(), path.end(), '/', '.');
    // Simulink's "structure with time": its signal is called like the structure.
    if (constexpr std::string_view values = ".signals.values"; is_matlab_ && path.ends_with(values))
      path = path.substr(0, path.size() - values.size()).append(".").append(path, 0, path.size() - values.size());
    const auto mark = path.find_last_of(is_matlab_ ? '.' : '/');
    array.group = mark == path.npos ? "" : path.substr(0, mark + 1);
    array.name = mark == path.npos ? path : path.substr(mark + 1);
    for (const char* key : {"units", "unit", "Units", "Unit", "unit_string"})
      if (array.unit.empty()) array.unit = text_attribute(*dataset.id, key).value_or("");
    array.rate_hz = rate_attribute(*dataset.id);
    if (array.rate_hz == 0.0 && dataset.has_path) array.rate_hz = rate_around(dataset.path);
    const Hdf5Id space(H5Dget_space(*dataset.id), H5Sclose);
    const int rank = H5Sget_simple_extent_ndims(space);
    dataset.dims.resize(static_cast<std::size_t>(std::max(rank, 0)));
    H5Sget_simple_extent_dims(space, dataset.dims.data(), nullptr);
    double size = 1.0;
    for (std::size_t i = 0; i < dataset.dims.size(); ++i) {
      const std::size_t axis = is_matlab_ ? dataset.dims.size() - 1 - i : i;
      array.shape.push_back(static_cast<std::int64_t>(std::min<hsize_t>(dataset.dims[axis], INT64_MAX)));
      if (dataset.dims[axis] != 1) dataset.long_axes.push_back(axis);
      size *= static_cast<double>(dataset.dims[axis]);
    }
    const Hdf5Id creation(H5Dget_create_plist(*dataset.id), H5Pclose);
    constexpr double most_packed = 1100.0;  // times: what deflate reaches is 1032
    if (H5Pget_layout(creation) == H5D_VIRTUAL || H5Pget_external_count(creation) > 0)
      array.kind = "outside this file";
    else if (rank < 0 || H5Aexists(*dataset.id, "MATLAB_empty") > 0)
      array.kind = "empty";
    else if (size > 0.0 && H5Dget_storage_size(*dataset.id) == 0)
      array.kind = "never written";
    else if (size > most_packed * static_cast<double>(bytes_))
      array.kind = "larger than the file can hold";
    return array;
  }

  static void set_kind(FileArray& array, hid_t type, const std::string& matlab) {
    const bool is_number = is_number_type(type);
    const bool is_float = H5Tget_class(type) == H5T_FLOAT;
    const std::size_t bytes = H5Tget_size(type);
    const bool is_matlab_number =
        matlab.empty() || std::find(matlab_numbers.begin(), matlab_numbers.end(), matlab) != matlab_numbers.end();
    if (!matlab.empty())
      array.kind = is_matlab_number || matlab == "char" || matlab == "cell" || matlab == "struct"
                       ? matlab
                       : clean_name(matlab) + ": save its columns as vectors";
    else if (is_number)
      array.kind = fmt::format("{}{}",
                               is_float                            ? "float"
                               : H5Tget_sign(type) == H5T_SGN_NONE ? "uint"
                                                                   : "int",
                               8 * bytes);
    else
      array.kind = H5Tget_class(type) == H5T_STRING ? "text" : "of another type";
    if (is_number && is_matlab_number)
      array.values = !is_float ? ValueKind::integers : bytes > 4 ? ValueKind::doubles : ValueKind::singles;
  }

  // {real, imag} is how complex numbers are stored.
  void add_members(const FileArray& whole, const Dataset& dataset, hid_t type) {
    std::vector<std::string> names;
    for (int i = 0; i < H5Tget_nmembers(type); ++i) {
      char* name = H5Tget_member_name(type, static_cast<unsigned>(i));
      names.emplace_back(name != nullptr ? name : "");
      H5free_memory(name);
    }
    const bool is_complex =
        names == std::vector<std::string>{"real", "imag"} || names == std::vector<std::string>{"r", "i"};
    if (is_complex || names.empty()) {
      contents_.arrays.push_back(whole);
      contents_.arrays.back().kind = is_complex ? "complex double" : "empty";
      return;
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      const Hdf5Id own(H5Tget_member_type(type, static_cast<unsigned>(i)), H5Tclose);
      FileArray array = whole;
      array.group += whole.name + (is_matlab_ ? "." : "/");
      array.name = names[i];
      set_kind(array, own, "");
      Dataset member = dataset;
      member.member = names[i];
      if (array.values != ValueKind::none) make_readable(array, std::move(member));
      contents_.arrays.push_back(std::move(array));
    }
  }

  // Of numbers, few; false: it is none of those.
  bool add_cells(const Dataset& dataset, const std::string& path) {
    constexpr hsize_t most = 1000;
    hsize_t count = 1;
    for (const hsize_t side : dataset.dims)
      if (__builtin_mul_overflow(count, side, &count)) return false;
    if (count == 0 || count > most) return false;
    std::vector<hobj_ref_t> references(static_cast<std::size_t>(count));
    if (H5Dread(*dataset.id, H5T_STD_REF_OBJ, H5S_ALL, H5S_ALL, H5P_DEFAULT, references.data()) < 0) dataset.refuse();
    for (std::size_t i = 0; i < references.size(); ++i) {
      auto cell =
          std::make_shared<Hdf5Id>(H5Rdereference2(*dataset.id, H5P_DEFAULT, H5R_OBJECT, &references[i]), H5Oclose);
      if (cell->is_open() && H5Iget_type(*cell) == H5I_DATASET)
        add(std::move(cell), fmt::format("{}_{}", path, i + 1), true);
    }
    return true;
  }

  void make_readable(FileArray& array, Dataset dataset) {
    array.bytes = widen_cache(dataset);
    array.read = [dataset = std::make_shared<const Dataset>(std::move(dataset))](int axis, std::int64_t first,
                                                                                 std::int64_t count, double* into) {
      dataset->read(axis, first, count, into);
    };
  }

  // Chunks that lie side by side are unpacked once if they all fit. How many bytes they are.
  double widen_cache(Dataset& dataset) const {
    constexpr std::size_t usual_bytes = 1 << 20, usual_slots = 521, slots_each = 11;
    const Hdf5Id creation(H5Dget_create_plist(*dataset.id), H5Pclose), type(H5Dget_type(*dataset.id), H5Tclose);
    std::vector<hsize_t> chunk(dataset.dims.size());
    if (chunk.empty() || H5Pget_layout(creation) != H5D_CHUNKED ||
        H5Pget_chunk(creation, static_cast<int>(chunk.size()), chunk.data()) < 0)
      return 0.0;
    const auto longest = std::max_element(dataset.dims.begin(), dataset.dims.end()) - dataset.dims.begin();
    double chunk_bytes = static_cast<double>(H5Tget_size(type)), beside = 1.0;
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      chunk_bytes *= static_cast<double>(chunk[i]);
      if (static_cast<std::ptrdiff_t>(i) != longest && chunk[i] > 0)
        beside *= std::ceil(static_cast<double>(dataset.dims[i]) / static_cast<double>(chunk[i]));
    }
    require_memory(name_, chunk_bytes, max_memory_bytes_);
    const double all = chunk_bytes * beside;
    if (all <= usual_bytes || all > 0.5 * static_cast<double>(max_memory_bytes_) || !dataset.has_path)
      return chunk_bytes;
    const Hdf5Id access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
    const auto slots = std::max(usual_slots, slots_each * static_cast<std::size_t>(std::min(beside, 1e6)));
    H5Pset_chunk_cache(access, slots, static_cast<std::size_t>(all) + usual_bytes, 1.0);
    auto again = std::make_shared<Hdf5Id>(H5Dopen2(*file_, dataset.path.c_str(), access), H5Dclose);
    if (again->is_open()) dataset.id = std::move(again);
    return all;
  }

  std::string name_;
  std::uint64_t bytes_;
  std::size_t max_memory_bytes_;
  std::shared_ptr<Hdf5Id> file_;
  bool is_matlab_ = false;
  ArrayContents contents_;
};

}  // namespace

bool is_hdf5(std::string_view head) {
  return head.starts_with(hdf5_magic) ||
         (head.size() > matlab_block && head.substr(matlab_block).starts_with(hdf5_magic));
}

std::unique_ptr<SampleSource> open_hdf5_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  const auto contents_of_file = [&] { return Hdf5Arrays(*file, options.max_memory_bytes).contents(); };
  if (!survives([&] { (void)contents_of_file(); }))
    throw Fault(FaultKind::input, "hdf5.damaged",
                fmt::format("{}: the HDF5 library breaks down over it, as over some damaged files. Copy the file from "
                            "its source again",
                            file->name()));
  ArrayContents contents = contents_of_file();
  return open_arrays(std::move(file), std::move(contents), options);
}

}  // namespace dsp
