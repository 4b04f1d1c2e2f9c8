#include "dsp/io/flac_end.hpp"

#include <algorithm>
#include <string>
#include <string_view>

namespace dsp {
namespace {

std::uint64_t big_endian(std::string_view bytes) {
  std::uint64_t number = 0;
  for (const char byte : bytes) number = number << 8 | static_cast<unsigned char>(byte);
  return number;
}

// As a frame's header holds its number: like UTF-8, continued beyond it.
std::string coded(std::uint64_t number) {
  if (number < 0x80) return std::string(1, static_cast<char>(number));
  std::string bytes;
  int lead_bits = 6;
  for (; number >> lead_bits != 0; number >>= 6, --lead_bits)
    bytes.insert(bytes.begin(), static_cast<char>(0x80 | (number & 0x3f)));
  return static_cast<char>((0xffu << (lead_bits + 1) & 0xffu) | number) + bytes;
}

// Zero over a whole frame, whose last two bytes are its remainder.
std::uint16_t crc16(std::string_view bytes) {
  unsigned remainder = 0;
  for (const char byte : bytes) {
    remainder ^= static_cast<unsigned>(static_cast<unsigned char>(byte)) << 8;
    for (int bit = 0; bit < 8; ++bit) remainder = (remainder << 1 ^ (remainder & 0x8000u ? 0x8005u : 0u)) & 0xffffu;
  }
  return static_cast<std::uint16_t>(remainder);
}

}  // namespace

bool ends_in_last_frame(const InputFile& file, std::int64_t num_frames) {
  constexpr std::size_t head_bytes = 18;  // "fLaC", the first block's own head, lengths of blocks and frames
  const std::string head = file.text(0, head_bytes);
  if (head.size() < head_bytes || !head.starts_with("fLaC")) return false;
  const auto number = [&](std::size_t at, std::size_t count) {
    return big_endian(std::string_view(head).substr(at, count));
  };
  const std::uint64_t length = number(8, 2), longest_frame = number(15, 3);
  if (num_frames < 1 || length == 0 || length != number(10, 2)) return false;
  const std::uint64_t count = std::min(longest_frame, file.size());
  const std::string tail = file.text(file.size() - count, count);
  const std::string last = coded(static_cast<std::uint64_t>(num_frames - 1) / length);
  constexpr std::string_view begin = "\xff\xf8";  // of a frame among others of its length
  constexpr std::size_t before_number = 4;
  for (auto at = tail.find(begin); at != std::string::npos; at = tail.find(begin, at + 1))
    if (tail.compare(std::min(at + before_number, tail.size()), last.size(), last) == 0 &&
        crc16(std::string_view(tail).substr(at)) == 0)
      return true;
  return false;
}

}  // namespace dsp
