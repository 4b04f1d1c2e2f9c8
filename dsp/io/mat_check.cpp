#include "dsp/io/mat_check.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include "dsp/values/fault.hpp"

namespace dsp {
namespace {

// Types of data elements and classes of arrays, as the MAT-File Format document numbers them.
constexpr std::uint32_t int8_type = 1, int32_type = 5, uint32_type = 6, matrix_type = 14, compressed_type = 15;
constexpr std::array<std::uint64_t, 19> type_bytes{0, 1, 1, 2, 2, 4, 4, 4, 0, 8, 0, 0, 8, 8, 0, 0, 1, 2, 4};
enum ArrayClass : std::uint32_t {
  cell_class = 1,
  struct_class = 2,
  char_class = 4,
  sparse_class = 5,
  function_class = 16,
  opaque_class = 17
};

struct Element {
  std::uint32_t type = 0;
  std::string_view data;
};

// The elements of a buffer one behind the other, each within it.
class Elements {
 public:
  Elements(std::string_view bytes, bool swapped) : rest_(bytes), swapped_(swapped) {}
  [[nodiscard]] bool done() const { return rest_.size() < 8; }  // fewer than a tag: padding
  [[nodiscard]] std::uint32_t number(std::string_view bytes, std::size_t at) const {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, 4);
    return swapped_ ? __builtin_bswap32(value) : value;
  }
  bool next(Element& element) {
    if (done()) return false;
    const std::uint32_t first = number(rest_, 0);
    if (first >> 16 != 0) {  // small: up to 4 bytes within the tag
      element = {first & 0xffff, rest_.substr(4, first >> 16)};
      if (first >> 16 > 4) return false;
      rest_.remove_prefix(8);
      return true;
    }
    const std::uint64_t size = number(rest_, 4), padded = (size + 7) / 8 * 8;
    if (size > rest_.size() - 8) return false;
    element = {first, rest_.substr(8, size)};
    rest_.remove_prefix(std::min<std::uint64_t>(8 + padded, rest_.size()));
    return true;
  }

 private:
  std::string_view rest_;
  bool swapped_;
};

std::uint64_t product(const Elements& numbers, std::string_view dims) {
  std::uint64_t result = 1;
  for (std::size_t at = 0; at + 4 <= dims.size(); at += 4)
    if (__builtin_mul_overflow(result, numbers.number(dims, at), &result))
      return std::numeric_limits<std::uint64_t>::max();
  return result;
}

bool matrix_is_sound(std::string_view bytes, bool swapped, int depth);

bool has_matrices(Elements& elements, std::uint64_t count, bool swapped, int depth) {
  Element element;
  for (; count > 0; --count)  // each takes 8 bytes at least, so a huge count ends early
    if (!elements.next(element) || element.type != matrix_type || !matrix_is_sound(element.data, swapped, depth + 1))
      return false;
  return true;
}

bool has_values(Elements& elements, std::uint64_t count) {
  Element values;
  if (!elements.next(values) || values.type >= type_bytes.size()) return false;
  const auto size = type_bytes[values.type];
  return size > 0 && count <= values.data.size() && values.data.size() == count * size;
}

// Flags, dimensions and name agree with what follows them. An empty element is an empty array.
bool matrix_is_sound(std::string_view bytes, bool swapped, int depth) {
  constexpr int deepest = 32;
  if (bytes.empty()) return true;
  Elements elements(bytes, swapped);
  Element flags, dims, name;
  if (depth > deepest || !elements.next(flags) || flags.type != uint32_type || flags.data.size() != 8) return false;
  const auto flag_bits = elements.number(flags.data, 0), kind = flag_bits & 0xff;
  const bool opaque = kind == opaque_class;  // without dimensions, and not read beyond its name
  if (kind < cell_class || kind > opaque_class) return false;
  if (!opaque && (!elements.next(dims) || dims.type != int32_type || dims.data.size() < 8 || dims.data.size() % 4 != 0))
    return false;
  // Only variables have names.
  if (!elements.next(name) || name.type != int8_type || (depth > 0 && !name.data.empty())) return false;
  if (opaque) return true;
  const std::uint64_t count = product(elements, dims.data);
  const bool complex = (flag_bits & 0x800) != 0;
  if (kind == cell_class) return has_matrices(elements, count, swapped, depth);
  if (kind == struct_class) {
    Element length, names;
    if (!elements.next(length) || length.type != int32_type || length.data.size() != 4 || !elements.next(names) ||
        names.type != int8_type)
      return false;
    const std::uint64_t each = elements.number(length.data, 0);
    std::uint64_t fields = 0;
    if (each == 0 || __builtin_mul_overflow(count, names.data.size() / each, &fields)) return false;
    return names.data.size() % each == 0 && has_matrices(elements, fields, swapped, depth);
  }
  if (kind == sparse_class || kind < char_class || kind == function_class) return true;  // not read
  if (count == 0) return true;
  return has_values(elements, count) && (!complex || has_values(elements, count));
}

[[noreturn]] void refuse(const InputFile& file, std::string name, std::uint64_t offset, const std::string& what) {
  throw Fault(FaultKind::input, std::move(name),
              fmt::format("{}: {} (element at byte {} of {}). Copy the file from its source again", file.name(), what,
                          offset, file.size()));
}

struct InflateEnd {
  void operator()(z_stream* stream) const {
    inflateEnd(stream);
    delete stream;
  }
};

// A compressed element whole, its checksum verified. `left` is how many bytes may still be expanded.
std::string inflate_element(const InputFile& file, std::uint64_t offset, std::uint64_t size, std::uint64_t left,
                            bool swapped) {
  std::unique_ptr<z_stream, InflateEnd> stream(new z_stream{});
  if (inflateInit(stream.get()) != Z_OK) throw std::bad_alloc();
  std::string expanded, input;
  constexpr std::uint64_t piece_bytes = 1 << 18;
  int status = Z_OK;
  for (std::uint64_t done = 0; status == Z_OK;) {
    if (stream->avail_in == 0) {
      input = file.text(offset + done, std::min(piece_bytes, size - done));
      done += input.size();
      stream->next_in = reinterpret_cast<Bytef*>(input.data());
      stream->avail_in = static_cast<uInt>(input.size());
    }
    const auto kept = expanded.size();
    if (kept >= left)
      refuse(file, "mat.size", offset,
             fmt::format("a variable expands beyond the {} bytes allowed (--max-memory)", left));
    expanded.resize(kept + std::min<std::uint64_t>(piece_bytes, left - kept));
    stream->next_out = reinterpret_cast<Bytef*>(expanded.data() + kept);
    stream->avail_out = static_cast<uInt>(expanded.size() - kept);
    status = inflate(stream.get(), Z_NO_FLUSH);
    expanded.resize(expanded.size() - stream->avail_out);
    // What its tag promises, so that a string that grows need not be held twice.
    if (kept == 0 && expanded.size() >= 8)
      expanded.reserve(
          std::min<std::uint64_t>(left, 8 + Elements(expanded, swapped).number(expanded, 4) + piece_bytes));
  }
  if (status != Z_STREAM_END) refuse(file, "mat.damaged", offset, "a compressed variable is damaged");
  return expanded;
}

// Variables of level 4: type, rows, columns, whether complex, length of the name; the name; the numbers.
void check_level_4(const InputFile& file, std::size_t max_memory_bytes) {
  constexpr std::uint64_t header_bytes = 20;
  constexpr std::array<std::uint64_t, 6> bytes_each{8, 4, 4, 2, 2, 1};
  std::uint64_t left = max_memory_bytes;
  for (std::uint64_t offset = 0; offset < file.size();) {
    const std::string header = file.text(offset, header_bytes);
    if (header.size() < header_bytes) refuse(file, "mat.truncated", offset, "the file ends within a header");
    // Thousands of the type say the byte order: 0 little, 1 big.
    Elements numbers(header, std::endian::native == std::endian::big);
    constexpr std::uint32_t highest_type = 52;
    if (numbers.number(header, 0) > highest_type)
      numbers = Elements(header, std::endian::native == std::endian::little);
    const std::uint32_t type = numbers.number(header, 0) % 1000, kind = type / 10;
    const std::uint64_t complex = numbers.number(header, 12), name = numbers.number(header, 16);
    std::uint64_t size = 0;
    if (type > highest_type || kind >= bytes_each.size() || complex > 1 || name < 1 ||
        __builtin_mul_overflow(std::uint64_t{numbers.number(header, 4)}, numbers.number(header, 8), &size) ||
        __builtin_mul_overflow(size, bytes_each[kind] * (1 + complex), &size))
      refuse(file, "mat.damaged", offset, "no variable begins where one should");
    const std::uint64_t there = file.size() - offset - header_bytes;
    if (name > there || size > there - name)
      refuse(file, "mat.truncated", offset,
             fmt::format("the file is cut: a variable of {} bytes, {} are there", size, there - std::min(there, name)));
    if (size > left)
      refuse(file, "mat.size", offset, fmt::format("a variable of {} bytes, {} allowed (--max-memory)", size, left));
    if (file.text(offset + header_bytes + name - 1, 1) != std::string(1, '\0'))
      refuse(file, "mat.damaged", offset, "a variable's name does not end");
    left -= size;
    offset += header_bytes + name + size;
  }
}

}  // namespace

MatLevel check_mat(const InputFile& file, std::size_t max_memory_bytes) {
  const std::string mark = file.text(126, 2);
  if (mark != "MI" && mark != "IM") {
    check_level_4(file, max_memory_bytes);
    return MatLevel::four;
  }
  const bool swapped = (file.text(126, 2) == "MI") == (std::endian::native == std::endian::little);
  std::uint64_t left = max_memory_bytes;
  for (std::uint64_t offset = 128; offset < file.size();) {
    const std::string tag = file.text(offset, 8);
    if (tag.size() < 8) refuse(file, "mat.truncated", offset, "the file ends within a tag");
    const Elements numbers(tag, swapped);
    const std::uint32_t type = numbers.number(tag, 0);
    const std::uint64_t size = numbers.number(tag, 4);
    if (type != matrix_type && type != compressed_type)
      refuse(file, "mat.damaged", offset, fmt::format("no variable begins where one should (type {})", type));
    if (size > file.size() - offset - 8)
      refuse(file, "mat.truncated", offset,
             fmt::format("the file is cut: a variable of {} bytes, {} are there", size, file.size() - offset - 8));
    if (size > left)
      refuse(file, "mat.size", offset, fmt::format("a variable of {} bytes, {} allowed (--max-memory)", size, left));
    const std::string body =
        type == compressed_type ? inflate_element(file, offset + 8, size, left, swapped) : file.text(offset, 8 + size);
    left -= std::min<std::uint64_t>(left, body.size());
    Elements elements(body, swapped);
    Element matrix;
    if (!elements.next(matrix) || matrix.type != matrix_type || !matrix_is_sound(matrix.data, swapped, 0))
      refuse(file, "mat.damaged", offset, "a variable's dimensions and its bytes disagree");
    offset += 8 + size;
  }
  return MatLevel::five;
}

}  // namespace dsp
