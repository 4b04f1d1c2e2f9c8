#include "dsp/io/sample_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "dsp/io/foreign_file.hpp"
#include "dsp/io/hdf5_file.hpp"
#include "dsp/io/input_file.hpp"
#include "dsp/io/json_file.hpp"
#include "dsp/io/mat_file.hpp"
#include "dsp/io/npy_file.hpp"
#include "dsp/io/sound_file.hpp"
#include "dsp/io/sound_header.hpp"
#include "dsp/io/table_file.hpp"
#include "dsp/io/tdms_file.hpp"
#include "dsp/io/uff_file.hpp"
#include "dsp/values/memory_limit.hpp"
#include "dsp/values/names.hpp"

namespace dsp {
namespace {

bool is_text_byte(char c) {
  return static_cast<unsigned char>(c) >= 0x20 || c == '\t' || c == '\n' || c == '\r';
}

// A brace, and behind it an opening quote, bracket or the end: "{System 1}" is a title.
bool is_json(std::string_view head) {
  const auto at = head.find_first_of("{[");
  if (at == head.npos || head.find_first_not_of(" \t\r\n") != at) return false;
  const auto behind = head.find_first_not_of(" \t\r\n", at + 1);
  return behind == head.npos || std::string_view("\"{[}]").find(head[behind]) != std::string_view::npos;
}

// With a mark at the beginning, or every other byte of its first letters nothing.
bool is_utf16(std::string_view head) {
  if (head.starts_with("\xff\xfe") || head.starts_with("\xfe\xff")) return true;
  constexpr std::size_t looked_at = 32;
  if (head.size() < looked_at) return false;
  for (const std::size_t zeros : {std::size_t{0}, std::size_t{1}}) {
    bool alternates = true;
    for (std::size_t i = 0; i < looked_at && alternates; ++i)
      alternates = (head[i] == '\0') == (i % 2 == zeros) && (head[i] == '\0' || is_text_byte(head[i]));
    if (alternates) return true;
  }
  return false;
}

// Letters outside the first 65,536 need two units; no table needs them, and each becomes a replacement character.
std::string from_utf16(std::string_view bytes) {
  const bool has_mark = bytes.front() == '\xff' || bytes.front() == '\xfe';
  const bool big = bytes.starts_with("\xfe\xff") || bytes.front() == '\0';
  std::string text;
  for (std::size_t i = has_mark ? 2 : 0; i + 1 < bytes.size(); i += 2) {
    const auto first = static_cast<unsigned char>(bytes[i]), second = static_cast<unsigned char>(bytes[i + 1]);
    unsigned unit = big ? first * 256u + second : second * 256u + first;
    if (unit >= 0xd800 && unit < 0xe000) unit = 0xfffd;
    if (unit < 0x80) {
      text += static_cast<char>(unit);
    } else if (unit < 0x800) {
      text += static_cast<char>(0xc0 | (unit >> 6));
      text += static_cast<char>(0x80 | (unit & 0x3f));
    } else {
      text += static_cast<char>(0xe0 | (unit >> 12));
      text += static_cast<char>(0x80 | ((unit >> 6) & 0x3f));
      text += static_cast<char>(0x80 | (unit & 0x3f));
    }
  }
  return text;
}

bool is_mat(std::string_view head) {
  if (head.size() < 128) return false;
  const auto tail = head.substr(124, 4);  // version 0x0100 and "MI", as the writer's byte order has it
  return tail == std::string_view("\0\1IM", 4) || tail == std::string_view("\1\0MI", 4);
}

// Level 4 begins with a number for type and byte order, rows, columns, whether complex, and the length of a name.
bool is_mat4(std::string_view head) {
  constexpr std::size_t header_bytes = 20, longest_name = 64;
  if (head.size() < header_bytes) return false;
  std::array<std::uint32_t, 5> words{};
  for (const bool big : {false, true}) {
    for (std::size_t i = 0; i < words.size(); ++i) {
      words[i] = 0;
      for (std::size_t k = 0; k < 4; ++k)
        words[i] |= std::uint32_t{static_cast<unsigned char>(head[4 * i + k])} << 8 * (big ? 3 - k : k);
    }
    const auto [type, rows, columns, complex, name] = words;
    constexpr std::uint32_t big_types = 1000,
                            most_type = 52;  // thousands say the byte order, the rest what numbers are
    const bool is_type = type / big_types == (big ? 1 : 0) && type % big_types <= most_type && type % 10 <= 2;
    if (is_type && rows > 0 && columns > 0 && complex <= 1 && name >= 2 && name <= longest_name &&
        head.size() >= header_bytes + name && head[header_bytes + name - 1] == '\0')
      return true;
  }
  return false;
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\n' && c != '\r' && c != '\f';
}

// A few control codes may occur in the names of a table; of bytes at random every ninth is one, and none of text is
// NUL.
bool is_text(std::string_view head) {
  constexpr std::ptrdiff_t always_borne = 4, one_in = 20;
  const auto odd = std::count_if(head.begin(), head.end(), is_control);
  return odd <= std::max(always_borne, static_cast<std::ptrdiff_t>(head.size()) / one_in) &&
         head.find('\0') == std::string_view::npos;
}

// Containers that go by an extension; empty for any other.
std::vector<std::string_view> containers_of(const std::string& written) {
  const std::string extension = lower(written);
  if (extension == ".wav" || extension == ".wave" || extension == ".rf64") return {"WAV", "RF64"};
  if (extension == ".w64") return {"W64"};
  if (extension == ".caf") return {"CAF"};
  if (extension == ".flac") return {"FLAC"};
  if (extension == ".aif" || extension == ".aiff" || extension == ".aifc") return {"AIFF"};
  if (extension == ".mat") return {"MATLAB"};
  if (extension == ".h5" || extension == ".hdf5" || extension == ".he5") return {"HDF5", "MATLAB v7.3"};
  if (extension == ".json" || extension == ".jsonl" || extension == ".ndjson") return {"JSON"};
  if (extension == ".npy" || extension == ".npz") return {"NumPy"};
  if (extension == ".csv" || extension == ".tsv" || extension == ".txt") return {"CSV", "text", "LabVIEW"};
  if (extension == ".lvm") return {"LabVIEW"};
  if (extension == ".tdms" || extension == ".tdms_index") return {"TDMS"};
  if (extension == ".uff" || extension == ".unv") return {"UFF"};
  return {};
}

std::unique_ptr<SampleSource> open_by_content(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  constexpr std::size_t head_bytes = 4096;
  std::string head = file->text(0, head_bytes);
  const bool is_decoded = is_utf16(head);  // what is read by other libraries is the file as it stands
  if (is_decoded) {
    constexpr double most_growth = 2.5;  // of the bytes: three for two, beside the two
    require_memory(file->name(), most_growth * static_cast<double>(file->size()), options.max_memory_bytes);
    file->replace_by(from_utf16(file->text(0, static_cast<std::size_t>(file->size()))));
    head = file->text(0, head_bytes);
  }
  if (!is_decoded && head.find('\n') == head.npos && head.find('\r') != head.npos && is_text(head)) {
    require_memory(file->name(), 2.0 * static_cast<double>(file->size()), options.max_memory_bytes);
    std::string lines = file->text(0, static_cast<std::size_t>(file->size()));  // they end as those of old Macintoshes
    std::replace(lines.begin(), lines.end(), '\r', '\n');
    file->replace_by(std::move(lines));
    head = file->text(0, head_bytes);
  }
  if (!is_decoded && is_sound(head)) return open_sound_file(std::move(file), options);
  if (!is_decoded && is_hdf5(head)) return open_hdf5_file(std::move(file), options);
  if (!is_decoded && is_npy(head)) return open_npy_file(std::move(file), options);
  if (!is_decoded && head.starts_with("PK\x03\x04")) return open_npz_file(std::move(file), options);
  if (!is_decoded && (is_mat(head) || is_mat4(head))) return open_mat_file(std::move(file), options);
  if (!is_decoded && is_tdms(head)) return open_tdms_file(std::move(file), options);
  if (is_uff(head)) return open_uff_file(std::move(file), options);
  refuse_foreign(*file, head);
  if (is_json(head)) return open_json_file(std::move(file), options);
  if (is_text(head)) return open_table_file(std::move(file), options);
  const auto odd = std::find_if(head.begin(), head.end(), is_control);
  throw Fault(FaultKind::input, "container.unknown",
              fmt::format("{}: no known container, and no text (byte {} is 0x{:02x}). Read are {}", file->name(),
                          odd - head.begin(), static_cast<unsigned char>(*odd), readable_formats));
}

}  // namespace

bool SampleSource::calibrate(const Eigen::VectorXd& /*scales*/, const Eigen::VectorXd& /*shifts*/) {
  return false;
}

Eigen::Index SampleSource::skip(Eigen::Index num_frames) {
  constexpr Eigen::Index block_frames = 16384;
  FrameBlock block;
  Eigen::Index skipped = 0;
  while (skipped < num_frames) {
    const Eigen::Index count = read(block, std::min(block_frames, num_frames - skipped));
    if (count == 0) break;
    skipped += count;
  }
  return skipped;
}

std::unique_ptr<SampleSource> open_source(const std::filesystem::path& file, const OpenOptions& options) {
  auto input = std::make_unique<InputFile>(file, options.may_be_quoted);
  const std::string name = input->name();
  if (input->size() == 0) throw Fault(FaultKind::input, "file.empty", fmt::format("{}: is empty (0 bytes)", name));
  auto source = open_by_content(std::move(input), options);
  const auto expected = containers_of(file.extension().string());
  const auto& container = source->info().container;
  if (!expected.empty() &&
      std::none_of(expected.begin(), expected.end(), [&](auto kind) { return container.starts_with(kind); }))
    source->add_check({"container.extension", "", CheckStatus::warning, 0.0, 0.0,
                       fmt::format("{}: by its content this is {}, whatever its name says", name, container)});
  return source;
}

}  // namespace dsp
