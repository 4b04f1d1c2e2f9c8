#include "dsp/io/tdms_bytes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

namespace dsp {
namespace {

const std::map<std::uint32_t, TdmsType>& tdms_types() {
  static const std::map<std::uint32_t, TdmsType> types{
      {0x01, {"int8", {'i', 1}, 1}},
      {0x02, {"int16", {'i', 2}, 2}},
      {0x03, {"int32", {'i', 4}, 4}},
      {0x04, {"int64", {'i', 8}, 8}},
      {0x05, {"uint8", {'u', 1}, 1}},
      {0x06, {"uint16", {'u', 2}, 2}},
      {0x07, {"uint32", {'u', 4}, 4}},
      {0x08, {"uint64", {'u', 8}, 8}},
      {0x09, {"single", {'f', 4}, 4}},
      {0x0a, {"double", {'f', 8}, 8}},
      {0x19, {"single", {'f', 4}, 4}},  // with a unit, which is a property
      {0x1a, {"double", {'f', 8}, 8}},
      {tdms_text_type, {"text", {'f', 0}, 0}},
      {0x21, {"logical", {'u', 1}, 1}},
      {tdms_time_type, {"time stamps", {'f', 0}, 16}},
      {0x08000c, {"complex single", {'f', 0}, 8}},
      {0x10000d, {"complex double", {'f', 0}, 16}},
  };
  return types;
}

}  // namespace

const TdmsType* find_tdms_type(std::uint32_t number) {
  const auto found = tdms_types().find(number);
  return found == tdms_types().end() ? nullptr : &found->second;
}

// The fraction comes first where the least significant byte does.
TdmsTime tdms_time(const char* bytes, bool is_big) {
  std::array<std::uint64_t, 2> halves{};
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t i = 0; i < 8; ++i)
      halves[k] |= std::uint64_t{static_cast<unsigned char>(bytes[8 * k + i])} << 8 * (is_big ? 7 - i : i);
  if (is_big) std::swap(halves[0], halves[1]);
  return {static_cast<std::int64_t>(halves[1]), std::ldexp(static_cast<double>(halves[0]), -64)};
}

std::string TdmsBytes::text(std::size_t most) {
  const auto size = number<std::uint32_t>();
  if (size > to_ - at_) throw damaged(fmt::format("a text of {} bytes goes beyond the metadata", size));
  std::string text(size > most ? 0 : size, '\0');
  if (size > most)
    at_ += size;
  else
    take(text.data(), text.size());
  return text;
}

TdmsValue TdmsBytes::value(const TdmsType& type, std::size_t most) {
  if (type.bytes == 0) return text(most);
  std::array<char, 16> bytes{};
  take(bytes.data(), static_cast<std::size_t>(type.bytes));
  if (type.format.bytes == 0) return tdms_time(bytes.data(), is_big_);
  NumberFormat format = type.format;
  format.swapped = is_big_ == (std::endian::native == std::endian::little);
  return format.value(bytes.data());
}

void TdmsBytes::skip(std::uint64_t count) {
  if (count > to_ - at_) throw damaged("the metadata end too early");
  at_ += count;
}

Fault TdmsBytes::damaged(const std::string& what) const {
  return {FaultKind::input, "tdms.damaged",
          fmt::format("{}: at byte {}: {}. Copy the file from its source again", file_.name(), at_, what)};
}

void TdmsBytes::take(void* into, std::size_t count) {
  constexpr std::uint64_t piece_bytes = 1 << 16;
  const std::uint64_t from = at_;
  skip(count);
  if (from < begin_ || at_ > begin_ + piece_.size()) {
    begin_ = from;
    piece_ = file_.text(from, std::max(count, static_cast<std::size_t>(std::min(piece_bytes, to_ - from))));
    if (piece_.size() < count) throw damaged("the file became shorter while it was read");
  }
  std::memcpy(into, piece_.data() + (from - begin_), count);
}

}  // namespace dsp
