#include "dsp/io/flac_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "dsp/fault.hpp"
#include "dsp/io/digest_beside.hpp"

namespace dsp {
namespace {

std::uint64_t big_endian(std::string_view bytes) {
  std::uint64_t number = 0;
  for (const char byte : bytes) number = number << 8 | static_cast<unsigned char>(byte);
  return number;
}

// The remainder of bytes by a polynomial of degree `bits`, highest power first: zero over what ends in its own.
template <int bits, unsigned polynomial>
unsigned remainder(std::string_view bytes) {
  static constexpr auto table = [] {
    std::array<unsigned, 256> of_byte{};
    for (unsigned byte = 0; byte < 256; ++byte) {
      unsigned value = byte << (bits - 8);
      for (int bit = 0; bit < 8; ++bit) value = value << 1 ^ ((value >> (bits - 1) & 1u) != 0 ? polynomial : 0u);
      of_byte[byte] = value & ((1u << bits) - 1);
    }
    return of_byte;
  }();
  unsigned value = 0;
  for (const char byte : bytes)
    value = (value << 8 ^ table[(value >> (bits - 8) ^ static_cast<unsigned char>(byte)) & 0xffu]) & ((1u << bits) - 1);
  return value;
}
constexpr auto head_remainder = remainder<8, 0x07>;
constexpr auto block_remainder = remainder<16, 0x8005>;

struct Block {
  std::int64_t first = 0, length = 0;  // frames
};

constexpr std::size_t longest_head = 16;

// The head of a block that begins here (RFC 9639, 9.1), if one does.
std::optional<Block> block_at(std::string_view bytes, const FlacStream& stream) {
  bytes = bytes.substr(0, longest_head);
  const auto byte = [&](std::size_t at) { return at < bytes.size() ? static_cast<unsigned char>(bytes[at]) : 0u; };
  if (bytes.size() < 6 || byte(0) != 0xff || (byte(1) & 0xfe) != 0xf8) return std::nullopt;
  const unsigned length_code = byte(2) >> 4, rate_code = byte(2) & 0xf;
  if (length_code == 0 || rate_code == 15 || (byte(3) & 1) != 0) return std::nullopt;
  // The number is coded like UTF-8, continued beyond it.
  std::size_t at = 5;
  std::int64_t number = byte(4);
  if (number >= 0x80) {
    if (number < 0xc0 || number == 0xff) return std::nullopt;
    std::size_t more = 0;
    while ((byte(4) << (more + 1) & 0x80) != 0) ++more;
    number &= (0x3f >> more);
    for (; more > 0; --more, ++at) number = number << 6 | (byte(at) & 0x3f);
  }
  Block block;
  block.length = length_code == 1   ? 192
                 : length_code < 6  ? 576 << (length_code - 2)
                 : length_code == 6 ? byte(at) + 1
                 : length_code == 7 ? (byte(at) << 8 | byte(at + 1)) + 1
                                    : 256 << (length_code - 8);
  at += length_code == 6 ? 1 : length_code == 7 ? 2 : 0;
  at += rate_code == 12 ? 1 : rate_code > 12 ? 2 : 0;
  if (at >= bytes.size() || head_remainder(bytes.substr(0, at + 1)) != 0) return std::nullopt;
  const bool by_frame = (byte(1) & 1) != 0;  // blocks of varying length
  if (!by_frame && stream.block_frames == 0) return std::nullopt;
  block.first = by_frame ? number : number * stream.block_frames;
  return block;
}

}  // namespace

FlacStream flac_stream(const InputFile& file) {
  constexpr std::size_t info_at = 8, info_bytes = 34;  // "fLaC" and a block's own head before it
  const std::string head = file.text(0, info_at + info_bytes);
  if (head.size() < info_at + info_bytes)
    throw Fault(FaultKind::input, "container.damaged",
                fmt::format("{}: the FLAC header is cut at byte {}", file.name(), file.size()));
  const auto number = [&](std::size_t at, std::size_t count) {
    return big_endian(std::string_view(head).substr(info_at + at, count));
  };
  FlacStream stream;
  stream.block_frames = number(0, 2) == number(2, 2) ? static_cast<std::int64_t>(number(0, 2)) : 0;
  stream.longest_block = number(7, 3);
  stream.bits = static_cast<int>(number(12, 2) >> 4 & 0x1f) + 1;
  stream.num_frames = static_cast<std::int64_t>(number(13, 5) & 0xfffffffff);
  stream.md5 = head.substr(info_at + 18, 16);
  if (stream.md5.find_first_not_of('\0') == std::string::npos) stream.md5.clear();
  stream.first_block = 4;
  for (bool last = false; !last;) {
    const std::string own = file.text(stream.first_block, 4);
    if (own.size() < 4) break;
    last = (own[0] & 0x80) != 0;
    stream.first_block += 4 + big_endian(std::string_view(own).substr(1));
  }
  return stream;
}

std::optional<std::int64_t> frames_by_last_block(const InputFile& file, const FlacStream& stream) {
  const std::uint64_t count = std::min(stream.longest_block, file.size());
  const std::string tail = file.text(file.size() - count, count);
  for (auto at = tail.find('\xff'); at != std::string::npos; at = tail.find('\xff', at + 1)) {
    const auto rest = std::string_view(tail).substr(at);
    if (const auto block = block_at(rest, stream); block && block_remainder(rest) == 0)
      return block->first + block->length;
  }
  return std::nullopt;
}

std::optional<MisplacedBlock> misplaced_block(const InputFile& file, const FlacStream& stream) {
  constexpr std::size_t piece_bytes = std::size_t{1} << 20;
  std::uint64_t previous = stream.first_block;
  std::int64_t due = 0;
  for (std::uint64_t offset = stream.first_block; offset < file.size(); offset += piece_bytes) {
    const std::string piece = file.text(offset, piece_bytes + longest_head);
    for (auto at = piece.find('\xff'); at < piece_bytes; at = piece.find('\xff', at + 1)) {
      const auto block = block_at(std::string_view(piece).substr(at), stream);
      if (!block) continue;
      const std::uint64_t here = offset + at;
      // Not the one due: a block out of place, if one ended here, else other bytes that look like a head.
      if (block->first != due &&
          (here - previous > piece_bytes || block_remainder(file.text(previous, here - previous)) != 0))
        continue;
      if (block->first != due) return MisplacedBlock{here, block->first, due};
      previous = here;
      due = block->first + block->length;
    }
  }
  return std::nullopt;
}

namespace {

// Whole numbers, least byte first.
template <std::size_t width>
void put_samples(const double* samples, std::size_t count, double full_scale, unsigned char* to) {
  for (std::size_t i = 0; i < count; ++i, to += width) {
    const auto value = static_cast<std::int64_t>(samples[i] * full_scale);
    for (std::size_t b = 0; b < width; ++b) to[b] = static_cast<unsigned char>(value >> 8 * b);
  }
}

}  // namespace

struct FlacDigest::State {
  DigestBeside md5;
  std::size_t sample_bytes = 0;
  double full_scale = 1.0;
};

FlacDigest::FlacDigest(int bits, int num_threads)
    : state_(new State{.md5 = {Digest::Method::md5, num_threads},
                       .sample_bytes = static_cast<std::size_t>((bits + 7) / 8),
                       .full_scale = std::ldexp(1.0, bits - 1)}) {}
FlacDigest::~FlacDigest() = default;
FlacDigest::FlacDigest(FlacDigest&&) noexcept = default;

void FlacDigest::push(const double* samples, std::size_t count) {
  constexpr std::size_t piece = 4096;  // samples, small enough for the processor's first cache
  constexpr std::array put{put_samples<1>, put_samples<2>, put_samples<3>, put_samples<4>};
  std::array<unsigned char, 4 * piece> bytes;
  const auto width = state_->sample_bytes;
  for (std::size_t done = 0; done < count; done += piece) {
    const auto now = std::min(piece, count - done);
    put[width - 1](samples + done, now, state_->full_scale, bytes.data());
    state_->md5.push({reinterpret_cast<const char*>(bytes.data()), now * width});
  }
}

std::string FlacDigest::finish() {
  return state_->md5.finish();
}

}  // namespace dsp
