#include "dsp/io/sound_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sndfile.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <tuple>
#include <type_traits>
#include <utility>

#include "dsp/io/flac_stream.hpp"
#include "dsp/io/sound_bytes.hpp"
#include "dsp/io/sound_handle.hpp"
#include "dsp/io/sound_header.hpp"
#include "dsp/names.hpp"

namespace dsp {
namespace {

[[noreturn]] void refuse(std::string name, const std::string& message) {
  throw Fault(FaultKind::input, std::move(name), message);
}

struct Codec {
  int subtype;
  std::string_view name;
  bool scaled;
  int sample_bytes;  // 0: packed
};
constexpr std::array codecs{
    Codec{SF_FORMAT_PCM_S8, "8 bit", true, 1},         Codec{SF_FORMAT_PCM_U8, "8 bit", true, 1},
    Codec{SF_FORMAT_PCM_16, "16 bit", true, 2},        Codec{SF_FORMAT_PCM_24, "24 bit", true, 3},
    Codec{SF_FORMAT_PCM_32, "32 bit", true, 4},        Codec{SF_FORMAT_FLOAT, "32 bit float", false, 4},
    Codec{SF_FORMAT_DOUBLE, "64 bit float", false, 8}, Codec{SF_FORMAT_ALAC_16, "ALAC 16 bit", true, 0},
    Codec{SF_FORMAT_ALAC_20, "ALAC 20 bit", true, 0},  Codec{SF_FORMAT_ALAC_24, "ALAC 24 bit", true, 0},
    Codec{SF_FORMAT_ALAC_32, "ALAC 32 bit", true, 0},
};

Check warning(std::string name, double value, double limit, std::string message) {
  return {std::move(name), "", CheckStatus::warning, value, limit, std::move(message)};
}

// What is wrong with the sizes: a fault, or a warning when what is left is to be read.
std::optional<Check> judge(const SoundHeader& header, const InputFile& file, bool salvage) {
  using State = SoundHeader::State;
  if (header.state == State::complete || header.state == State::streamed) return std::nullopt;
  const auto frame = std::max<std::uint64_t>(header.frame_bytes, 1);
  const auto promised = header.promised_bytes / frame, present = header.present_bytes / frame;
  const auto [name, what] =
      header.state == State::truncated
          ? std::pair{"container.truncated",
                      fmt::format("the header promises {} frames, {} are there", promised, present)}
      : header.state == State::unfinished
          ? std::pair{"container.unfinished",
                      fmt::format("the header says 0 frames, {} follow it: the recorder stopped without finishing",
                                  present)}
          : std::pair{
                "container.wrapped",
                fmt::format("the header says {} frames, {} follow it{}", promised, present,
                            header.present_bytes > 0xffffffff ? ": sizes beyond 4 GiB do not fit its 32 bits" : "")};
  const auto message = fmt::format("{}: {}", file.name(), what);
  if (!salvage) refuse(name, message + ". Try --salvage to read what is there");
  return warning(name, static_cast<double>(present), static_cast<double>(promised),
                 message + "; what is there was read");
}

class SoundFile : public SampleSource {
 public:
  SoundFile(std::unique_ptr<InputFile> file, const OpenOptions& options)
      : header_(read_sound_header(*file)), salvage_(options.salvage), handle_(nullptr, sf_close) {
    const auto size_check = judge(header_, *file, salvage_);
    if (header_.container == "FLAC") flac_ = flac_stream(*file);
    bytes_ = std::make_unique<SoundBytes>(std::move(file), header_.salvage, header_.data_offset);
    SF_INFO sound = open();
    describe(sound);
    info_.checks.insert(info_.checks.end(), header_.checks.begin(), header_.checks.end());
    if (size_check) info_.checks.push_back(*size_check);
    const bool streamed = header_.state == SoundHeader::State::streamed;
    if (!flac_) return;
    if (!flac_->md5.empty()) digest_.emplace(flac_->bits);
    if (streamed || salvage_)
      count_frames(streamed);
    else
      try_last_frame();
  }

  Eigen::Index read(FrameBlock& block, Eigen::Index max_frames) override {
    block.resize(max_frames, static_cast<Eigen::Index>(info_.columns.size()));
    const auto got = static_cast<Eigen::Index>(sf_readf_double(handle_.get(), block.data(), max_frames));
    bytes_->rethrow();
    num_read_ += got;
    // A cut FLAC ends in an error; when it is salvaged, that is behind the last frame counted.
    const bool past_end = salvage_ && num_read_ == info_.num_frames;
    if (sf_error(handle_.get()) != SF_ERR_NO_ERROR && !past_end) damaged(sf_strerror(handle_.get()));
    digest_frames(block.data(), got);
    if (got == 0 && max_frames > 0) finish();
    if (got < max_frames) block.conservativeResize(got, Eigen::NoChange);
    return got;
  }

 private:
  [[nodiscard]] const std::string& name() const { return bytes_->file().name(); }

  [[noreturn]] void damaged(std::string_view why) const {
    // Whether a FLAC holds the frames it promises shows only on decoding them.
    if (header_.container == "FLAC")
      refuse("container.truncated",
             fmt::format("{}: the header promises {} frames, {} could be decoded ({}). Try --salvage to read what is "
                         "there",
                         name(), info_.num_frames, num_read_, clean_name(why)));
    refuse("container.damaged", fmt::format("{}: cannot be decoded beyond frame {} of {}: {}", name(), num_read_,
                                            info_.num_frames, clean_name(why)));
  }

  void digest_frames(const double* frames, std::int64_t count) {
    if (digest_) digest_->push(frames, static_cast<std::size_t>(count) * info_.columns.size());
  }

  void finish() {
    if (num_read_ < info_.num_frames) damaged("the data end there");
    bytes_->file().check_unchanged();
    if (!flac_ || salvage_) return;
    if (const auto wrong = sequence_fault())
      refuse("container.damaged",
             fmt::format("{}: {}. Copy the file from its source again, or try --salvage to read it "
                         "as it is",
                         name(), *wrong));
  }

  // A block that is missing, or there twice, shifts all behind it and shows in no checksum of a block.
  [[nodiscard]] std::optional<std::string> sequence_fault() {
    auto digest = std::exchange(digest_, std::nullopt);
    if (digest && digest->finish() == flac_->md5) return std::nullopt;
    const auto place = misplaced_block(bytes_->file(), *flac_);
    if (!digest) return place;
    return "the decoded samples do not have the MD5 in its header: " +
           place.value_or("its blocks follow one another, so samples were changed or the header is of another file");
  }

  void describe(const SF_INFO& sound) {
    constexpr int highest_rate_hz = 100'000'000, most_channels = 1024;
    const auto codec = std::find_if(codecs.begin(), codecs.end(), [&](const Codec& known) {
      return known.subtype == (sound.format & SF_FORMAT_SUBMASK);
    });
    if (codec == codecs.end())
      refuse("container.lossy",
             fmt::format("{}: its codec is lossy, companded or rare; want 16, 24 or 32 bit PCM, float or "
                         "FLAC",
                         name()));
    const double rate_hz = header_.rate_hz > 0 ? header_.rate_hz : sound.samplerate;
    if (sound.channels < 1 || sound.channels > most_channels || !(rate_hz >= 1) || rate_hz > highest_rate_hz)
      refuse("container.limit", fmt::format("{}: {} channels at {} Hz; want 1 to {} channels at 1 to {} Hz", name(),
                                            sound.channels, rate_hz, most_channels, highest_rate_hz));
    const int frame_bytes = sound.channels * codec->sample_bytes;
    const bool stated = !flac_ && header_.container != "AIFF";  // how far frames lie apart
    if (stated && frame_bytes > 0 && header_.frame_bytes != static_cast<unsigned>(frame_bytes))
      refuse(
          "container.unsupported",
          fmt::format("{}: {} channels of {} take {} bytes a frame, the header says {}: padded samples are not read. "
                      "Export it with packed samples",
                      name(), sound.channels, codec->name, frame_bytes, header_.frame_bytes));
    info_.container = fmt::format("{}, {}", header_.container, codec->name);
    info_.sample_rate_hz = rate_hz;
    info_.num_frames = sound.frames;
    info_.columns.resize(static_cast<std::size_t>(sound.channels));
    info_.units.resize(info_.columns.size());
    info_.scaled = codec->scaled;
    if (const char* comment = sf_get_string(handle_.get(), SF_STR_COMMENT))
      info_.checks.push_back({"container.comment", "", CheckStatus::note, 0.0, 0.0, clean_name(comment)});
  }

  SF_INFO open() {
    SF_INFO sound{};
    bytes_->seek(0, SEEK_SET);
    handle_.reset(sf_open_virtual(virtual_calls<SoundBytes>(), SFM_READ, &sound, bytes_.get()));
    bytes_->rethrow();
    if (!handle_)
      refuse("container.damaged", fmt::format("{}: {} header cannot be read: {}", name(), header_.container,
                                              clean_name(sf_strerror(nullptr))));
    return sound;
  }

  // FLAC that promises no count, or perhaps too many frames. The decoder does not recover from having failed, hence the
  // second opening.
  void count_frames(bool streamed) {
    std::vector<double> frames(std::size_t{4096} * info_.columns.size());
    const auto promised = info_.num_frames;
    info_.num_frames = 0;
    const auto take = [&] { return sf_readf_double(handle_.get(), frames.data(), 4096); };
    for (sf_count_t got = take(); got > 0; got = take()) {
      info_.num_frames += got;
      if (salvage_) digest_frames(frames.data(), got);
    }
    bytes_->rethrow();
    open();
    if (streamed || info_.num_frames == promised) {
      const auto wrong = salvage_ ? sequence_fault() : std::nullopt;
      if (wrong)
        info_.checks.push_back(
            warning("container.damaged", 0.0, 0.0, fmt::format("{}: {}; it was read as it is", name(), *wrong)));
      return;
    }
    digest_.reset();
    info_.checks.push_back(
        warning("container.truncated", static_cast<double>(info_.num_frames), static_cast<double>(promised),
                fmt::format("{}: the header promises {} frames, {} could be decoded; these were read", name(), promised,
                            info_.num_frames)));
  }

  // A FLAC cut short shows without decoding all of it: its last frame is not there. Reading will say where it ends.
  void try_last_frame() {
    if (info_.num_frames == 0 || frames_by_last_block(bytes_->file(), *flac_)) return;
    std::vector<double> frame(info_.columns.size());
    const bool there = sf_seek(handle_.get(), info_.num_frames - 1, SEEK_SET) >= 0 &&
                       sf_readf_double(handle_.get(), frame.data(), 1) == 1;
    bytes_->rethrow();
    open();
    if (there) return;
    info_.checks.push_back(warning("container.truncated", 0.0, static_cast<double>(info_.num_frames),
                                   fmt::format("{}: the header promises {} frames, the last of which cannot be decoded",
                                               name(), info_.num_frames)));
  }

  SoundHeader header_;
  bool salvage_;
  std::optional<FlacStream> flac_;
  std::optional<FlacDigest> digest_;  // of what has been read
  std::unique_ptr<SoundBytes> bytes_;
  SoundHandle handle_;  // after bytes_: closed before them
  std::int64_t num_read_ = 0;
};

}  // namespace

std::unique_ptr<SampleSource> open_sound_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  return std::make_unique<SoundFile>(std::move(file), options);
}

}  // namespace dsp
