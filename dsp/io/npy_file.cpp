#include "dsp/io/npy_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <optional>

#include "dsp/io/array_file.hpp"
#include "dsp/io/foreign_file.hpp"
#include "dsp/io/table_cells.hpp"
#include "dsp/io/zip_archive.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

constexpr std::string_view magic("\x93NUMPY", 6);

/// Where the bytes of a .npy are, which may be a member of an archive.
struct NpySource {
  std::string name;  ///< for messages
  std::uint64_t size = 0;
  std::function<std::string(std::uint64_t offset, std::size_t count)> text;
  ArrayBytes bytes;
};

/// A piece of a Python literal: as much of it as a header of NumPy has.
class Literal {
 public:
  explicit Literal(std::string_view text) : rest_(text) {}
  bool take(char wanted) {
    blanks();
    if (rest_.empty() || rest_.front() != wanted) return false;
    rest_.remove_prefix(1);
    return true;
  }
  std::optional<std::string> text() {
    blanks();
    if (rest_.empty() || (rest_.front() != '\'' && rest_.front() != '"')) return std::nullopt;
    const auto end = rest_.find(rest_.front(), 1);
    if (end == rest_.npos) return std::nullopt;
    std::string found(rest_.substr(1, end - 1));
    rest_.remove_prefix(end + 1);
    return found;
  }
  std::optional<std::uint64_t> number() {
    blanks();
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (error != std::errc()) return std::nullopt;
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
  }
  std::string word() {
    blanks();
    const auto end = std::min(rest_.find_first_of(",}) "), rest_.size());
    std::string found(rest_.substr(0, end));
    rest_.remove_prefix(end);
    return found;
  }
  /// The numbers of a tuple; nothing where it is none.
  std::optional<std::vector<std::uint64_t>> tuple() {
    std::vector<std::uint64_t> numbers;
    if (!take('(')) return std::nullopt;
    constexpr std::size_t most = 32;
    while (!take(')')) {
      const auto side = number();
      if (!side || numbers.size() > most) return std::nullopt;
      numbers.push_back(*side);
      (void)take('L');  // Python 2
      (void)take(',');
    }
    return numbers;
  }

 private:
  void blanks() { rest_ = rest_.substr(std::min(rest_.find_first_not_of(" \t\n"), rest_.size())); }
  std::string_view rest_;
};

/// A number in each row or record.
struct NpyField {
  std::string name, kind, unit;
  NumberFormat format;
  std::vector<std::uint64_t> shape;  // of one that is several
  std::uint64_t bytes = 0;
};

struct NpyHeader {
  std::vector<NpyField> fields;
  bool is_record = false, is_fortran = false;
  std::vector<std::uint64_t> shape;
  std::uint64_t data_offset = 0, item_bytes = 0;
};

// "<f8", "|i1", ">M8[ns]".
std::optional<NpyField> field_of(std::string name, const std::string& type) {
  if (type == "|O") return NpyField{.name = std::move(name), .kind = "object", .format = {.bytes = 0}, .bytes = 8};
  if (type.size() < 3) return std::nullopt;
  NpyField field{.name = std::move(name), .kind = type};
  const auto [end, error] = std::from_chars(type.data() + 2, type.data() + type.size(), field.bytes);
  constexpr std::uint64_t most_bytes = 1 << 20;
  if (error != std::errc() || field.bytes == 0 || field.bytes > most_bytes) return std::nullopt;
  char kind = type[1];
  if (kind == 'b') kind = 'u';
  if (kind == 'M' || kind == 'm') {  // times in the unit behind
    field.unit = unquoted(std::string_view(end, static_cast<std::size_t>(type.data() + type.size() - end)));
    field.unit = field.unit.size() > 2 ? field.unit.substr(1, field.unit.size() - 2) : "";
    kind = 'i';
  }
  if (kind == 'U') field.bytes *= 4;
  const bool is_big = type[0] == '>';
  if (kind == 'f' || kind == 'i' || kind == 'u')
    field.format = {kind, static_cast<int>(std::min<std::uint64_t>(field.bytes, 64)),
                    type[0] != '|' && is_big == (std::endian::native == std::endian::little)};
  else
    field.format.bytes = 0;  // text, complex, objects
  constexpr std::array<std::pair<char, const char*>, 5> words{
      {{'f', "float"}, {'i', "int"}, {'u', "uint"}, {'c', "complex"}, {'O', "object"}}};
  for (const auto& [letter, word] : words)
    if (type[1] == letter) field.kind = fmt::format("{}{}", word, letter == 'O' ? "" : std::to_string(8 * field.bytes));
  if (type[1] == 'U' || type[1] == 'S') field.kind = "text";
  if (type[1] == 'b') field.kind = "logical";
  return field;
}

std::optional<NpyField> next_field(Literal& literal) {
  if (!literal.take('(')) return std::nullopt;
  const auto name = literal.text();
  if (!name || !literal.take(',')) return std::nullopt;
  const auto type = literal.text();
  if (!type) return std::nullopt;
  auto field = field_of(*name, *type);
  if (!field) return std::nullopt;
  if (literal.take(',')) {
    const auto shape = literal.tuple();
    if (!shape) return std::nullopt;
    field->shape = *shape;
    for (const std::uint64_t side : *shape)
      if (side == 0 || __builtin_mul_overflow(field->bytes, side, &field->bytes)) return std::nullopt;
  }
  return literal.take(')') ? field : std::nullopt;
}

// The dictionary: 'descr', 'fortran_order' and 'shape' in any order.
std::optional<NpyHeader> parsed(std::string_view text) {
  constexpr std::size_t most_fields = 10'000;
  NpyHeader header;
  Literal literal(text);
  if (!literal.take('{')) return std::nullopt;
  bool has_shape = false;
  while (!literal.take('}')) {
    const auto key = literal.text();
    if (!key || !literal.take(':')) return std::nullopt;
    if (*key == "descr" && literal.take('[')) {
      header.is_record = true;
      while (!literal.take(']')) {
        auto field = next_field(literal);
        if (!field || header.fields.size() > most_fields) return std::nullopt;
        header.fields.push_back(std::move(*field));
        (void)literal.take(',');
      }
    } else if (*key == "descr") {
      const auto type = literal.text();
      auto field = type ? field_of("", *type) : std::nullopt;
      if (!field) return std::nullopt;
      header.fields.push_back(std::move(*field));
    } else if (*key == "shape") {
      const auto shape = literal.tuple();
      if (!shape) return std::nullopt;
      header.shape = *shape;
      has_shape = true;
    } else {
      header.is_fortran = literal.word() == "True";
    }
    (void)literal.take(',');
  }
  for (const NpyField& field : header.fields) header.item_bytes += field.bytes;
  return has_shape && !header.fields.empty() ? std::optional(header) : std::nullopt;
}

NpyHeader read_header(const NpySource& source) {
  const auto refuse = [&](const std::string& what) {
    return Fault(FaultKind::input, "npy.header",
                 fmt::format("{}: {}. Save it again with numpy.save", source.name, what));
  };
  constexpr std::size_t prefix_bytes = 8, most_bytes = 1 << 20;
  const std::string begin = source.text(0, prefix_bytes + 4);
  if (!begin.starts_with(magic) || begin.size() < prefix_bytes + 4) throw refuse("is no array of NumPy");
  const std::size_t length_bytes = begin[6] == 1 ? 2 : 4;
  std::size_t length = 0;
  for (std::size_t i = length_bytes; i-- > 0;)
    length = 256 * length + static_cast<unsigned char>(begin[prefix_bytes + i]);
  if (begin[6] < 1 || begin[6] > 3 || length > most_bytes) throw refuse("its header is of no known version");
  const std::string text = source.text(prefix_bytes + length_bytes, length);
  if (text.size() < length) throw refuse(fmt::format("its header is cut ({} of {} bytes)", text.size(), length));
  auto header = parsed(text);
  if (!header) throw refuse(fmt::format("its header is not understood: '{}'", clean_name(text)));
  header->data_offset = prefix_bytes + length_bytes + length;
  return *header;
}

std::uint64_t num_items(const NpyHeader& header) {
  std::uint64_t count = 1;
  for (const std::uint64_t side : header.shape)
    if (__builtin_mul_overflow(count, side, &count)) return ~std::uint64_t{0};
  return count;
}

// Rows are lost behind the end of a file that was cut; of one that is stored column by column nothing can be used.
void check_size(const NpySource& source, NpyHeader& header, bool salvage, std::vector<Check>& checks) {
  const std::uint64_t there = source.size - std::min(source.size, header.data_offset);
  const std::uint64_t count = num_items(header);
  std::uint64_t promised = 0;
  const bool is_absurd = __builtin_mul_overflow(count, header.item_bytes, &promised);
  if (is_absurd) promised = ~std::uint64_t{0};
  const std::string sizes =
      fmt::format("{}: its header promises {} bytes of numbers, {} are there", source.name, promised, there);
  if (promised == there) return;
  const bool can_salvage = !is_absurd && promised > there && !header.shape.empty() &&
                           (!header.is_fortran || header.shape.size() == 1) && count > 0;
  if (!salvage || !can_salvage)
    throw Fault(
        FaultKind::input, "container.truncated",
        fmt::format("{}. {}", sizes,
                    can_salvage ? "Try --salvage to read what is left" : "Copy the file from its source again"));
  header.shape[0] = there / (promised / header.shape[0]);
  checks.push_back({"container.truncated", "", CheckStatus::warning, static_cast<double>(there),
                    static_cast<double>(promised), fmt::format("{}; {} rows were read", sizes, header.shape[0])});
}

void add_arrays(const NpySource& source, const std::string& name, bool salvage, ArrayContents& contents) {
  NpyHeader header = read_header(source);
  check_size(source, header, salvage, contents.checks);
  std::uint64_t offset = header.data_offset;
  for (const NpyField& field : header.fields) {
    FileArray array{.group = header.is_record && !name.empty() ? name + "." : "",
                    .name = header.is_record ? field.name : name,
                    .unit = field.unit,
                    .kind = field.kind,
                    .values = field.format.bytes > 0 ? field.format.values() : ValueKind::none};
    std::vector<std::uint64_t> all = header.shape, all_steps(all.size()), shape, steps;
    std::uint64_t step = header.item_bytes;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const std::size_t side = header.is_fortran ? k : all.size() - 1 - k;
      all_steps[side] = step;
      step *= all[side];
    }
    step = static_cast<std::uint64_t>(field.format.bytes);
    for (std::size_t k = field.shape.size(); k-- > 0;) {
      all_steps.insert(all_steps.begin() + static_cast<std::ptrdiff_t>(header.shape.size()), step);
      step *= field.shape[k];
    }
    all.insert(all.end(), field.shape.begin(), field.shape.end());
    for (std::size_t k = 0; k < all.size(); ++k) {
      array.shape.push_back(static_cast<std::int64_t>(std::min<std::uint64_t>(all[k], INT64_MAX)));
      if (all[k] == 1) continue;
      shape.push_back(all[k]);
      steps.push_back(all_steps[k]);
    }
    if (array.values != ValueKind::none) array.read = strided(field.format, shape, steps, offset, source.bytes);
    contents.arrays.push_back(std::move(array));
    offset += field.bytes;
  }
}

// What an archive without arrays may be, and what makes a table of it.
Fault not_numpy(const InputFile& file, const std::vector<ZipMember>& members) {
  const auto has = [&](std::string_view begin) {
    return std::any_of(members.begin(), members.end(), [&](const auto& one) { return one.name.starts_with(begin); });
  };
  return foreign_archive(file, has("xl/")                              ? ForeignArchive::spreadsheet
                               : has("content.xml") && has("mimetype") ? ForeignArchive::open_document
                                                                       : ForeignArchive::zip);
}

}  // namespace

bool is_npy(std::string_view head) {
  return head.starts_with(magic);
}

std::unique_ptr<SampleSource> open_npy_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  const InputFile* const in = file.get();
  NpySource source{in->name(), in->size(),
                   [in](std::uint64_t offset, std::size_t count) { return in->text(offset, count); },
                   read_from(*in, 0)};
  ArrayContents contents{.container = "NumPy npy", .prefix = "npy"};
  add_arrays(source, "", options.salvage, contents);
  return open_arrays(std::move(file), std::move(contents), options);
}

std::unique_ptr<SampleSource> open_npz_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  ArrayContents contents{.container = "NumPy npz", .prefix = "npz"};
  std::size_t left = options.max_memory_bytes;
  const std::vector<ZipMember> members = zip_members(*file);
  for (const ZipMember& member : members) {
    if (!member.name.ends_with(".npy")) {
      contents.left_out.push_back(clean_name(member.name));
      continue;
    }
    const std::string name = clean_name(std::string_view(member.name).substr(0, member.name.size() - 4));
    const auto opened = open_member(*file, member, left);
    NpySource source{fmt::format("{}: {}", file->name(), name), member.size,
                     [opened](std::uint64_t offset, std::size_t count) { return opened->text(offset, count); },
                     [opened](std::uint64_t offset, std::size_t count) { return opened->bytes(offset, count); }};
    add_arrays(source, name, false, contents);
  }
  if (contents.arrays.empty()) throw not_numpy(*file, members);
  return open_arrays(std::move(file), std::move(contents), options);
}

}  // namespace dsp
