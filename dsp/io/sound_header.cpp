#include "dsp/io/sound_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "dsp/io/flac_stream.hpp"
#include "dsp/io/input_file.hpp"

namespace dsp {
namespace {

std::uint64_t little(std::string_view bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

std::uint64_t big(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<unsigned char>(byte);
  return value;
}

std::string little_bytes(std::uint64_t value, int count) {
  std::string bytes;
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> 8 * i & 0xff);
  return bytes;
}

std::string big_bytes(std::uint64_t value, int count) {
  std::string bytes = little_bytes(value, count);
  std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

constexpr std::uint64_t most_format_bytes = 4096;
constexpr std::uint64_t open_size_32 = 0xffffffff, open_size_64 = ~std::uint64_t{0};
constexpr std::string_view w64_riff("riff\x2e\x91\xcf\x11\xa5\xd6\x28\xdb\x04\xc1\x00\x00", 16);
constexpr std::string_view w64_tail("\xf3\xac\xd3\x11\x8c\xd1\x00\xc0\x4f\x8e\xdb\x8a",
                                    12);  // of every other W64 chunk's id

// How the chunks of a container are laid out.
struct Layout {
  std::string container, data_id, format_id;
  std::uint64_t first_chunk, id_bytes, size_bytes, alignment;
  bool big_endian, size_counts_header;
};

Layout layout_of(std::string_view head) {
  if (head.starts_with("RIFF")) return {"WAV", "data", "fmt ", 12, 4, 4, 2, false, false};
  if (head.starts_with("RF64")) return {"RF64", "data", "fmt ", 12, 4, 4, 2, false, false};
  if (head.starts_with("caff")) return {"CAF", "data", "desc", 8, 4, 8, 1, true, false};
  if (head.starts_with("FORM")) return {"AIFF", "SSND", "COMM", 12, 4, 4, 2, true, false};
  return {"W64", "data", "fmt ", 40, 16, 8, 8, false, true};
}

struct Chunk {
  std::string id;
  std::uint64_t at = 0, body = 0, size = 0;  ///< of the body, as promised
};

class Chunks {
 public:
  Chunks(const InputFile& file, Layout layout) : file_(file), layout_(std::move(layout)), next_(layout_.first_chunk) {}

  /// Nothing at the end of the file or where no chunk begins.
  std::optional<Chunk> next() {
    const std::uint64_t header = layout_.id_bytes + layout_.size_bytes;
    const std::string bytes = file_.text(next_, header);
    if (bytes.size() < header) return std::nullopt;
    Chunk chunk{bytes.substr(0, 4), next_, next_ + header, number(std::string_view(bytes).substr(layout_.id_bytes))};
    const bool printable = std::all_of(chunk.id.begin(), chunk.id.end(), [](char c) { return c >= ' ' && c <= '~'; });
    const bool known = layout_.id_bytes == 4 || std::string_view(bytes).substr(4, 12) == w64_tail;
    if (!printable || !known || (layout_.size_counts_header && chunk.size < header)) return std::nullopt;
    if (layout_.size_counts_header) chunk.size -= header;
    // Sizes are anything at all in a hostile file: stay at or beyond its end, never come back from there.
    const std::uint64_t end = chunk.size > file_.size() ? file_.size() : chunk.body + chunk.size;
    next_ = end + (layout_.alignment - end % layout_.alignment) % layout_.alignment;
    if (++count_ > most_chunks) return std::nullopt;
    return chunk;
  }
  [[nodiscard]] std::uint64_t position() const { return next_; }
  void jump(std::uint64_t to) { next_ = to; }
  [[nodiscard]] std::uint64_t number(std::string_view bytes) const {
    return layout_.big_endian ? big(bytes) : little(bytes);
  }

 private:
  const InputFile& file_;
  Layout layout_;
  std::uint64_t next_;
  static constexpr int most_chunks = 10'000;
  int count_ = 0;
};

std::uint64_t header_bytes(const Layout& layout) {
  return layout.id_bytes + layout.size_bytes;
}

// The bytes before the samples with sizes that include all that is there. A WAV becomes an RF64: 32 bits may not do.
std::string salvage_head(const SoundHeader& header, const Layout& layout, std::string head, const std::string& format,
                         std::uint64_t data_at) {
  const auto present = header.present_bytes;
  const auto preamble = header.data_offset - data_at - header_bytes(layout);
  const auto put = [&](std::uint64_t at, const std::string& bytes) { head.replace(at, bytes.size(), bytes); };
  const auto frames = present / std::max<std::uint64_t>(header.frame_bytes, 1);
  if (layout.container == "WAV" || layout.container == "RF64") {
    const std::string padded = format.size() % 2 == 0 ? format : format + '\0';
    return "RF64" + little_bytes(open_size_32, 4) + "WAVEds64" + little_bytes(28, 4) +
           little_bytes(present + padded.size() + 56, 8) + little_bytes(present, 8) + little_bytes(frames, 8) +
           little_bytes(0, 4) + padded + "data" + little_bytes(open_size_32, 4);
  }
  if (layout.container == "W64") put(data_at + layout.id_bytes, little_bytes(present + header_bytes(layout), 8));
  if (layout.container == "CAF") put(data_at + layout.id_bytes, big_bytes(present + preamble, 8));
  if (layout.container == "AIFF")
    put(data_at + layout.id_bytes, big_bytes(std::min(present + preamble, open_size_32), 4));
  return head;
}

std::uint64_t frame_bytes(const std::string& container, std::string_view format) {
  if (container == "CAF") return format.size() < 20 ? 0 : big(format.substr(16, 4));
  if (container == "AIFF")
    return format.size() < 8 ? 0 : big(format.substr(0, 2)) * ((big(format.substr(6, 2)) + 7) / 8);
  return format.size() < 14 ? 0 : little(format.substr(12, 2));
}

// The bits of a sample, and of the extended format how many of them count.
void read_bits(std::string_view format, SoundHeader& header) {
  constexpr std::uint64_t extensible = 0xfffe;
  if (format.size() < 16) return;
  header.sample_bits = static_cast<int>(little(format.substr(14, 2)));
  const bool extended = format.size() >= 20 && little(format.substr(0, 2)) == extensible;
  if (extended) header.valid_bits = static_cast<int>(little(format.substr(18, 2)));
}

// A double in CAF, 80 bits (sign and exponent, then 64 of mantissa) in AIFF.
double real_rate_hz(const std::string& container, std::string_view format) {
  if (container == "CAF" && format.size() >= 8) return std::bit_cast<double>(big(format.substr(0, 8)));
  if (container != "AIFF" || format.size() < 18) return 0.0;
  constexpr int exponent_of_one = 16383 + 63;
  return std::ldexp(static_cast<double>(big(format.substr(10, 8))),
                    static_cast<int>(big(format.substr(8, 2))) - exponent_of_one);
}

// Whether well-formed chunks lead from the end of the data to the end of the file, but for a few stray bytes.
bool chunks_reach_end(Chunks& chunks, std::uint64_t file_size) {
  constexpr std::uint64_t stray_bytes = 4096;
  while (chunks.position() + stray_bytes < file_size) {
    const auto chunk = chunks.next();
    if (!chunk || chunk->body + chunk->size > file_size) return false;
  }
  return true;
}

Check note(std::string name, std::string message) {
  return {std::move(name), "", CheckStatus::note, 0.0, 0.0, std::move(message)};
}

// What the last block's number contradicts is known before anything is decoded.
SoundHeader flac_header(const InputFile& file) {
  using State = SoundHeader::State;
  SoundHeader header;
  header.container = "FLAC";
  const FlacStream stream = flac_stream(file);
  if (stream.num_frames == 0) header.state = State::streamed;
  const auto present = frames_by_last_block(file, stream);
  if (stream.num_frames == 0 || !present || *present == stream.num_frames) return header;
  header.state = *present < stream.num_frames ? State::truncated : State::wrapped;
  header.promised_bytes = static_cast<std::uint64_t>(stream.num_frames);
  header.present_bytes = static_cast<std::uint64_t>(*present);
  header.frame_bytes = 1;
  constexpr std::uint64_t count_at = 21, count_bytes = 5;  // the number of frames is the low 36 bits
  header.data_offset = count_at + count_bytes;
  header.salvage = file.text(0, header.data_offset);
  const auto count = big(std::string_view(header.salvage).substr(count_at)) >> 36 << 36 | header.present_bytes;
  header.salvage.replace(count_at, count_bytes, big_bytes(count, count_bytes));
  return header;
}

}  // namespace

bool is_sound(std::string_view head) {
  const auto at = [&](std::size_t offset, std::string_view text) {
    return head.size() >= offset + text.size() && head.substr(offset, text.size()) == text;
  };
  return (at(0, "RIFF") && at(8, "WAVE")) || (at(0, "RF64") && at(8, "WAVE")) || at(0, w64_riff) || at(0, "caff") ||
         (at(0, "FORM") && (at(8, "AIFF") || at(8, "AIFC"))) || at(0, "fLaC");
}

SoundHeader read_sound_header(const InputFile& file) {
  const std::string head = file.text(0, 40);
  if (head.starts_with("fLaC")) return flac_header(file);
  const Layout layout = layout_of(head);
  SoundHeader header;
  header.container = layout.container;
  if (layout.container == "WAV" || layout.container == "RF64") {
    const auto size = little(std::string_view(head).substr(4, 4));
    if (size == 0 || (size == open_size_32 && layout.container == "WAV"))
      header.checks.push_back(note("container.size", fmt::format("{}: the RIFF size is {}; the file's length is used",
                                                                 file.name(), size == 0 ? "0" : "FFFFFFFF")));
  }
  Chunks chunks(file, layout);
  std::optional<Chunk> data, ds64;
  std::string format;
  while (!data) {
    const auto position = chunks.position();
    const auto chunk = chunks.next();
    if (!chunk)
      throw Fault(FaultKind::input, "container.damaged",
                  fmt::format("{}: {} header without its '{}' chunk: no chunk begins at byte {} of {}", file.name(),
                              layout.container, layout.data_id, std::min(position, file.size()), file.size()));
    if (chunk->id == layout.format_id) {
      format = file.text(chunk->at, header_bytes(layout) + std::min<std::uint64_t>(chunk->size, most_format_bytes));
      const auto body = std::string_view(format).substr(header_bytes(layout));
      header.frame_bytes = frame_bytes(layout.container, body);
      header.rate_hz = real_rate_hz(layout.container, body);
      if (!layout.big_endian) read_bits(body, header);
    }
    if (chunk->id == "ds64") ds64 = chunk;
    if (chunk->id == layout.data_id) data = chunk;
  }
  const std::uint64_t preamble = layout.container == "CAF" ? 4 : layout.container == "AIFF" ? 8 : 0;
  header.data_offset = std::min(data->body + preamble, file.size());
  header.present_bytes = file.size() - header.data_offset;
  std::uint64_t promised = data->size;
  bool open = promised == (layout.size_bytes == 4 ? open_size_32 : open_size_64);
  if (ds64 && open) {  // RF64: the sizes that count are in ds64: RIFF, data, frames
    promised = little(file.text(ds64->body + 8, 8));
    open = false;
    chunks.jump(promised > file.size() ? file.size() : data->body + promised + promised % 2);
  }
  header.promised_bytes = open ? header.present_bytes : promised - std::min(promised, preamble);
  using State = SoundHeader::State;
  if (open) {
    header.state = State::streamed;
    header.checks.push_back(
        note("container.size",
             fmt::format("{}: the writer left the data size open; data are read to the end of the file", file.name())));
  } else if (header.promised_bytes > header.present_bytes) {
    header.state = State::truncated;
  } else if (!chunks_reach_end(chunks, file.size())) {
    header.state = header.promised_bytes == 0 ? State::unfinished : State::wrapped;
  } else if (header.promised_bytes == 0 && header.present_bytes >= std::max<std::uint64_t>(header.frame_bytes, 1)) {
    // Few bytes behind a size of 0 are data as well unless they are chunks.
    Chunks behind(file, layout);
    behind.jump(header.data_offset);
    if (!behind.next()) header.state = State::unfinished;
  }
  if (header.state != State::complete && header.state != State::streamed)
    header.salvage = salvage_head(header, layout, file.text(0, header.data_offset), format, data->at);
  return header;
}

}  // namespace dsp
