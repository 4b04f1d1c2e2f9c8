#include "dsp/io/sound_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "dsp/io/input_file.hpp"

namespace dsp {
namespace {

/// How the chunks of a container are laid out.
struct Layout {
  std::string_view magic, container, format_id, data_id;
  std::uint64_t first_chunk, id_bytes, size_bytes, alignment;
  std::uint64_t preamble;  ///< bytes of the chunk of samples before the first
  bool big_endian = false, size_counts_header = false;
};
constexpr std::array layouts{
    Layout{"RIFF", "WAV", "fmt ", "data", 12, 4, 4, 2, 0},
    Layout{"RF64", "RF64", "fmt ", "data", 12, 4, 4, 2, 0},
    Layout{"caff", "CAF", "desc", "data", 8, 4, 8, 1, 4, true},
    Layout{"FORM", "AIFF", "COMM", "SSND", 12, 4, 4, 2, 8, true},
    Layout{"riff", "W64", "fmt ", "data", 40, 16, 8, 8, 0, false, true},
};
constexpr std::string_view w64_riff("riff\x2e\x91\xcf\x11\xa5\xd6\x28\xdb\x04\xc1\x00\x00", 16);
constexpr std::string_view w64_tail("\xf3\xac\xd3\x11\x8c\xd1\x00\xc0\x4f\x8e\xdb\x8a",
                                    12);  // of every other W64 chunk's id
constexpr std::uint64_t open_size_32 = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t open_size_64 = std::numeric_limits<std::uint64_t>::max();
constexpr int most_chunks = 10'000;

/// 0 where there are fewer bytes.
std::uint64_t number(std::string_view bytes, std::size_t at, std::size_t count, bool big_endian) {
  std::uint64_t value = 0;
  if (bytes.size() < at + count) return value;
  for (std::size_t i = 0; i < count; ++i)
    value = value << 8 | static_cast<unsigned char>(bytes[at + (big_endian ? i : count - 1 - i)]);
  return value;
}

struct Chunk {
  std::string id;
  std::uint64_t body = 0, size = 0, next = 0;  ///< size of the body as promised, offset of the next chunk
};

/// Nothing at the end of the file or where no chunk begins.
std::optional<Chunk> chunk_at(const InputFile& file, const Layout& layout, std::uint64_t at) {
  const std::uint64_t header = layout.id_bytes + layout.size_bytes;
  const std::string bytes = file.text(at, header);
  if (bytes.size() < header) return std::nullopt;
  Chunk chunk{bytes.substr(0, 4), at + header, number(bytes, layout.id_bytes, layout.size_bytes, layout.big_endian)};
  const bool printable = std::all_of(chunk.id.begin(), chunk.id.end(), [](char c) { return c >= ' ' && c <= '~'; });
  const bool known = layout.id_bytes == 4 || std::string_view(bytes).substr(4, 12) == w64_tail;
  if (!printable || !known || (layout.size_counts_header && chunk.size < header)) return std::nullopt;
  if (layout.size_counts_header) chunk.size -= header;
  // Sizes are anything at all in a hostile file: none leads further than behind its end.
  const std::uint64_t end = chunk.body + std::min(chunk.size, file.size());
  chunk.next = end + (layout.alignment - end % layout.alignment) % layout.alignment;
  return chunk;
}

/// Whether well-formed chunks lead from `at` to the end of the file, but for a few stray bytes.
bool chunks_reach_end(const InputFile& file, const Layout& layout, std::uint64_t at, std::uint64_t stray_bytes) {
  for (int count = 0; at + stray_bytes < file.size(); ++count) {
    const auto chunk = count < most_chunks ? chunk_at(file, layout, at) : std::nullopt;
    if (!chunk || chunk->size > file.size() - chunk->body) return false;
    at = chunk->next;
  }
  return true;
}

void read_format(const Layout& layout, std::string_view format, SoundHeader& header) {
  constexpr int exponent_of_one = 16383 + 63;
  const auto field = [&](std::size_t at, std::size_t count) { return number(format, at, count, layout.big_endian); };
  if (layout.container == "CAF") {
    header.rate_hz = std::bit_cast<double>(field(0, 8));
    header.frame_bytes = field(16, 4);
  } else if (layout.container == "AIFF") {  // a rate of 80 bits: sign and exponent, then the mantissa
    header.frame_bytes = field(0, 2) * ((field(6, 2) + 7) / 8);
    header.rate_hz = std::ldexp(static_cast<double>(field(10, 8)), static_cast<int>(field(8, 2)) - exponent_of_one);
  } else {
    constexpr std::uint64_t extended = 0xfffe;
    header.frame_bytes = field(12, 2);
    header.sample_bits = static_cast<int>(field(14, 2));
    if (field(0, 2) == extended) header.valid_bits = static_cast<int>(field(18, 2));
  }
}

SoundHeader::State state_of(const SoundHeader& header, const InputFile& file, const Layout& layout) {
  using State = SoundHeader::State;
  constexpr std::uint64_t stray_bytes = 4096;
  if (header.promised_bytes > header.present_bytes) return State::truncated;
  // Less than a frame behind a size of 0 is nothing, as a few bytes behind samples are.
  const bool empty = header.promised_bytes == 0;
  const std::uint64_t end = header.data_offset + header.promised_bytes;
  const std::uint64_t behind = end + (layout.alignment - end % layout.alignment) % layout.alignment;
  const std::uint64_t stray = empty ? std::max<std::uint64_t>(header.frame_bytes, 1) - 1 : stray_bytes;
  if (chunks_reach_end(file, layout, behind, stray)) return State::complete;
  return empty ? State::unfinished : State::wrapped;
}

/// The size of the samples as its bytes in the header.
std::string size_bytes(std::uint64_t size, std::size_t count, bool big_endian) {
  std::string bytes(count, '\0');
  for (std::size_t i = 0; i < count; ++i)
    bytes[big_endian ? count - 1 - i : i] = static_cast<char>(size >> 8 * i & 0xff);
  return bytes;
}

}  // namespace

bool is_sound(std::string_view head) {
  const auto form = head.substr(std::min<std::size_t>(head.size(), 8), 4);
  return ((head.starts_with("RIFF") || head.starts_with("RF64")) && form == "WAVE") || head.starts_with(w64_riff) ||
         head.starts_with("caff") || (head.starts_with("FORM") && (form == "AIFF" || form == "AIFC")) ||
         head.starts_with("fLaC");
}

SoundHeader read_sound_header(const InputFile& file) {
  constexpr std::uint64_t most_format_bytes = 64;
  const std::string head = file.text(0, 8);
  const auto found =
      std::find_if(layouts.begin(), layouts.end(), [&](const Layout& known) { return head.starts_with(known.magic); });
  const Layout& layout = found == layouts.end() ? layouts.back() : *found;
  SoundHeader header;
  header.container = layout.container;
  Chunk data;
  std::optional<Chunk> ds64;
  for (int count = 0; data.id != layout.data_id; ++count) {
    const std::uint64_t at = count == 0 ? layout.first_chunk : data.next;
    const auto chunk = count < most_chunks ? chunk_at(file, layout, at) : std::nullopt;
    if (!chunk)
      throw Fault(FaultKind::input, "container.damaged",
                  fmt::format("{}: {} header without its '{}' chunk: no chunk begins at byte {} of {}", file.name(),
                              layout.container, layout.data_id, std::min(at, file.size()), file.size()));
    data = *chunk;
    if (data.id == layout.format_id)
      read_format(layout, file.text(data.body, std::min(data.size, most_format_bytes)), header);
    if (data.id == "ds64") ds64 = data;
  }
  header.data_offset = std::min(data.body + layout.preamble, file.size());
  header.present_bytes = file.size() - header.data_offset;
  header.size_offset = data.body - layout.size_bytes;
  std::uint64_t size_width = layout.size_bytes;
  bool open = data.size == (size_width == 4 ? open_size_32 : open_size_64);
  if (ds64 && open) {  // RF64: the sizes that count are in ds64: RIFF, data, frames
    open = false;
    size_width = 8;
    header.size_offset = ds64->body + 8;
    data.size = number(file.text(header.size_offset, size_width), 0, size_width, false);
  }
  header.promised_bytes = open ? header.present_bytes : data.size - std::min(data.size, layout.preamble);
  if (open) {
    header.state = SoundHeader::State::streamed;
    header.checks.push_back(
        {"container.size", "", CheckStatus::note, 0.0, 0.0,
         file.name() + ": the writer left the data size open; data are read to the end of the file"});
    return header;
  }
  header.state = state_of(header, file, layout);
  if (header.state == SoundHeader::State::complete) return header;
  const std::uint64_t counted = layout.size_counts_header ? layout.id_bytes + layout.size_bytes : layout.preamble;
  header.real_size = size_bytes(std::min(header.present_bytes + counted, size_width == 4 ? open_size_32 : open_size_64),
                                size_width, layout.big_endian);
  return header;
}

}  // namespace dsp
