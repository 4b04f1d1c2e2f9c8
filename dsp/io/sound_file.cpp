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
#include "dsp/io/pcm_samples.hpp"
#include "dsp/set_shape.hpp"
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
    if (!flac_->md5.empty()) digest_.emplace(flac_->bits, options.num_threads);
    if (streamed || salvage_)
      count_frames(streamed);
    else
      try_last_frame();
  }

  Eigen::Index read(FrameBlock& block, Eigen::Index max_frames) override {
    set_shape(block, max_frames, static_cast<Eigen::Index>(info_.columns.size()));
    const Eigen::Index got = decode(block);
    bytes_->rethrow();
    num_read_ += got;
    // A cut FLAC ends in an error; when it is salvaged, that is behind the last frame counted.
    const bool goes_on = salvage_ && (got > 0 || num_read_ == info_.num_frames);
    if (sf_error(handle_.get()) != SF_ERR_NO_ERROR && !goes_on) damaged(sf_strerror(handle_.get()));
    digest_frames(block.data(), got);
    if (max_frames > 0 && (got == 0 || (got < max_frames && num_read_ < info_.num_frames))) finish();
    if (got < max_frames) block.conservativeResize(got, Eigen::NoChange);
    return got;
  }

  bool calibrate(const Eigen::VectorXd& scales, const Eigen::VectorXd& shifts) override {
    if (pcm_) pcm_->calibrate(scales, shifts);
    return pcm_.has_value();
  }

  // A decoder of FLAC seeks no faster than it decodes.
  Eigen::Index skip(Eigen::Index num_frames) override {
    if (flac_) return SampleSource::skip(num_frames);
    const auto count = static_cast<Eigen::Index>(std::min<std::int64_t>(num_frames, info_.num_frames - num_read_));
    if (!pcm_ && sf_seek(handle_.get(), num_read_ + count, SEEK_SET) < 0) damaged(sf_strerror(handle_.get()));
    num_read_ += count;
    return count;
  }

 private:
  [[nodiscard]] const std::string& name() const { return bytes_->file().name(); }

  // The next frames into `block`, as many as it has rows. Of a FLAC that is salvaged as they were counted: where blocks
  // are missing, how many zeros the decoder puts in their place depends on how many frames it is asked for.
  Eigen::Index decode(FrameBlock& block) {
    if (pcm_) return decode_pcm(block);
    if (!flac_ || !salvage_)
      return static_cast<Eigen::Index>(sf_readf_double(handle_.get(), block.data(), block.rows()));
    Eigen::Index got = 0;
    while (got < block.rows()) {
      if (next_held_ == held_.rows()) {
        set_shape(held_, frames_at_a_time, block.cols());
        const auto count = sf_readf_double(handle_.get(), held_.data(), frames_at_a_time);
        held_.conservativeResize(static_cast<Eigen::Index>(count), Eigen::NoChange);
        next_held_ = 0;
        if (count == 0) break;
      }
      const auto count = std::min(block.rows() - got, held_.rows() - next_held_);
      block.middleRows(got, count) = held_.middleRows(next_held_, count);
      got += count;
      next_held_ += count;
    }
    return got;
  }

  // The same numbers straight from the bytes: half the price of the library's way. In pieces that the processor's cache
  // holds until they are converted.
  Eigen::Index decode_pcm(FrameBlock& block) {
    constexpr std::int64_t piece_bytes = std::int64_t{1} << 16;
    const std::int64_t frame_bytes = pcm_->frame_bytes();
    const std::int64_t wanted = std::min<std::int64_t>(block.rows(), info_.num_frames - num_read_);
    std::int64_t done = 0;
    while (done < wanted) {
      const std::int64_t count = std::min(wanted - done, std::max<std::int64_t>(piece_bytes / frame_bytes, 1));
      packed_.resize(static_cast<std::size_t>(count * frame_bytes));
      const auto at = header_.data_offset + static_cast<std::uint64_t>((num_read_ + done) * frame_bytes);
      const auto got = static_cast<std::int64_t>(bytes_->file().read(at, packed_.data(), packed_.size())) / frame_bytes;
      pcm_->decode(packed_.data(), got, block.data() + done * block.cols());
      done += got;
      if (got < count) break;
    }
    return done;
  }

  [[noreturn]] void damaged(std::string_view why) const {
    // Whether a FLAC holds the frames it promises shows only on decoding them.
    refuse(
        "container.truncated",
        fmt::format("{}: the header promises {} frames, {} could be decoded ({}). Try --salvage to read what is there",
                    name(), info_.num_frames, num_read_, clean_name(why)));
  }

  void digest_frames(const double* frames, std::int64_t count) {
    if (digest_) digest_->push(frames, static_cast<std::size_t>(count) * info_.columns.size());
  }

  void finish() {
    bytes_->file().check_unchanged();
    if (const auto wrong = flac_ && !salvage_ ? sequence_fault(num_read_, info_.num_frames) : std::nullopt)
      refuse("container.damaged",
             fmt::format("{}: {}. Copy the file from its source again, or try --salvage to read it "
                         "as it is",
                         name(), *wrong));
    if (num_read_ < info_.num_frames) damaged("the data end there");
  }

  // A block that is missing, or there twice, shifts all behind it and shows in no checksum of a block.
  [[nodiscard]] std::optional<std::string> sequence_fault(std::int64_t decoded, std::int64_t promised) {
    auto digest = std::exchange(digest_, std::nullopt);
    const bool is_of_all = digest && decoded == promised;  // else a digest is that of other samples
    if (is_of_all && digest->finish() == flac_->md5) return std::nullopt;
    std::optional<std::string> place;
    if (const auto block = misplaced_block(bytes_->file(), *flac_)) {
      place = fmt::format("at byte {} the block of frame {} comes where frame {} is due", block->offset, block->found,
                          block->due);
      // The decoder puts zeros into some of a gap or all of it; the last block tells what is missing at the end.
      const bool ends = frames_by_last_block(bytes_->file(), *flac_) == promised;
      const auto late = ends && block->found > block->due ? decoded - promised : block->due - block->found;
      *place += late == 0 ? ", with zeros in place of what is missing"
                          : fmt::format(", so that what follows is {} frames ({:.4g} s) {}", std::abs(late),
                                        static_cast<double>(std::abs(late)) / info_.sample_rate_hz,
                                        late > 0 ? "late" : "early");
    }
    if (!is_of_all) return place;
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
    check_frame(sound.channels, *codec);
    info_.container = fmt::format("{}, {}", header_.container, codec->name);
    info_.sample_rate_hz = rate_hz;
    info_.num_frames = sound.frames;
    info_.columns.resize(static_cast<std::size_t>(sound.channels));
    info_.units.resize(info_.columns.size());
    info_.scaled = codec->scaled;
    const bool lowest_byte_first =
        header_.container == "WAV" || header_.container == "RF64" || header_.container == "W64";
    if (lowest_byte_first && codec->scaled && codec->sample_bytes > 1)
      pcm_.emplace(codec->sample_bytes, sound.channels);
    if (const char* comment = sf_get_string(handle_.get(), SF_STR_COMMENT))
      info_.checks.push_back({"container.comment", "", CheckStatus::note, 0.0, 0.0, clean_name(comment)});
  }

  // Samples wider than their bits are read as if their upper bits counted, which not every writer means.
  void check_frame(int channels, const Codec& codec) {
    const bool stated = !flac_ && header_.container != "AIFF" && codec.sample_bytes > 0;  // how far frames lie apart
    const int stated_bytes = (header_.sample_bits + 7) / 8;
    const int sample_bytes = stated_bytes > 0 ? stated_bytes : codec.sample_bytes;
    if (stated && header_.frame_bytes != static_cast<unsigned>(channels * sample_bytes))
      refuse("container.unsupported",
             fmt::format("{}: {} channels of {} bit take {} bytes a frame, the header says {}: padded samples are not "
                         "read. Export it with packed samples",
                         name(), channels, header_.sample_bits > 0 ? header_.sample_bits : 8 * codec.sample_bytes,
                         channels * sample_bytes, header_.frame_bytes));
    if (header_.valid_bits > 0 && header_.valid_bits < header_.sample_bits)
      info_.checks.push_back({"container.bits", "", CheckStatus::note, static_cast<double>(header_.valid_bits),
                              static_cast<double>(header_.sample_bits),
                              fmt::format("{}: {} of the {} bits of a sample count, taken to be the upper ones", name(),
                                          header_.valid_bits, header_.sample_bits)});
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
    std::vector<double> frames(std::size_t{frames_at_a_time} * info_.columns.size());
    const auto promised = info_.num_frames;
    info_.num_frames = 0;
    const auto take = [&] { return sf_readf_double(handle_.get(), frames.data(), frames_at_a_time); };
    for (sf_count_t got = take(); got > 0; got = take()) {
      info_.num_frames += got;
      if (salvage_) digest_frames(frames.data(), got);
    }
    bytes_->rethrow();
    open();
    if (const auto wrong =
            salvage_ ? sequence_fault(info_.num_frames, streamed ? info_.num_frames : promised) : std::nullopt) {
      info_.checks.push_back(
          warning("container.damaged", 0.0, 0.0, fmt::format("{}: {}; it was read as it is", name(), *wrong)));
      return;
    }
    if (streamed || info_.num_frames == promised) return;
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

  static constexpr int frames_at_a_time = 4096;  // of a FLAC, when they are counted

  SoundHeader header_;
  bool salvage_;
  std::optional<FlacStream> flac_;
  std::optional<FlacDigest> digest_;  // of what has been read
  std::unique_ptr<SoundBytes> bytes_;
  SoundHandle handle_;  // after bytes_: closed before them
  std::int64_t num_read_ = 0;
  std::optional<PcmDecoder> pcm_;  // of what is read without the library
  std::vector<char> packed_;       // such frames, as the file holds them
  FrameBlock held_;                // decoded, and read up to next_held_
  Eigen::Index next_held_ = 0;
};

}  // namespace

std::unique_ptr<SampleSource> open_sound_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  return std::make_unique<SoundFile>(std::move(file), options);
}

}  // namespace dsp
