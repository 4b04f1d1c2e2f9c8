#include "dsp/io/sound_file.hpp"

#include <fmt/format.h>
#include <sndfile.h>

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <utility>

#include "dsp/io/flac_file.hpp"
#include "dsp/io/input_file.hpp"
#include "dsp/io/pcm_samples.hpp"
#include "dsp/io/sound_bytes.hpp"
#include "dsp/io/sound_handle.hpp"
#include "dsp/io/sound_header.hpp"
#include "dsp/values/names.hpp"
#include "dsp/values/set_shape.hpp"

namespace dsp {
namespace {

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
  if (!salvage) throw Fault(FaultKind::input, name, message + ". Try --salvage to read what is there");
  return Check{name,
               "",
               CheckStatus::warning,
               static_cast<double>(present),
               static_cast<double>(promised),
               message + "; what is there was read"};
}

class SoundFile : public SampleSource {
 public:
  SoundFile(std::unique_ptr<InputFile> file, const OpenOptions& options)
      : file_(std::move(file)),
        header_(read_sound_header(*file_)),
        salvage_(options.salvage),
        bytes_(*file_, 0, file_->size()),
        handle_(nullptr, sf_close) {
    const auto size_check = judge(header_, *file_, salvage_);
    bytes_.patch(header_.size_offset, header_.real_size);
    SF_INFO sound{};
    open(sound);
    describe(sound);
    info_.checks.insert(info_.checks.end(), header_.checks.begin(), header_.checks.end());
    if (size_check) info_.checks.push_back(*size_check);
  }

  Eigen::Index read(FrameBlock& block, Eigen::Index max_frames) override {
    set_shape(block, max_frames, static_cast<Eigen::Index>(info_.columns.size()));
    const auto got =
        pcm_ ? decode_pcm(block)
             : static_cast<Eigen::Index>(sf_readf_double(handle_.get(), block.data(), std::min(max_frames, left())));
    bytes_.rethrow();
    num_read_ += got;
    if (sf_error(handle_.get()) != SF_ERR_NO_ERROR && !salvage_) damaged(sf_strerror(handle_.get()));
    if (max_frames > 0 && (got == 0 || (got < max_frames && left() > 0))) {
      file_->check_unchanged();
      if (left() > 0) damaged("the data end there");
    }
    if (got < max_frames) block.conservativeResize(got, Eigen::NoChange);
    return got;
  }

  bool calibrate(const Eigen::VectorXd& scales, const Eigen::VectorXd& shifts) override {
    if (pcm_) pcm_->calibrate(scales, shifts);
    return pcm_.has_value();
  }

  Eigen::Index skip(Eigen::Index num_frames) override {
    const Eigen::Index count = std::min(num_frames, left());
    if (!pcm_ && sf_seek(handle_.get(), num_read_ + count, SEEK_SET) < 0) damaged(sf_strerror(handle_.get()));
    num_read_ += count;
    return count;
  }

 private:
  [[nodiscard]] Eigen::Index left() const { return static_cast<Eigen::Index>(info_.num_frames - num_read_); }

  // The same numbers straight from the bytes: half the price of the library's way. In pieces that the processor's cache
  // holds until they are converted.
  Eigen::Index decode_pcm(FrameBlock& block) {
    constexpr std::int64_t piece_bytes = std::int64_t{1} << 16;
    const std::int64_t frame_bytes = pcm_->frame_bytes();
    const std::int64_t wanted = std::min<std::int64_t>(block.rows(), left());
    std::int64_t done = 0;
    while (done < wanted) {
      const std::int64_t count = std::min(wanted - done, std::max<std::int64_t>(piece_bytes / frame_bytes, 1));
      packed_.resize(static_cast<std::size_t>(count * frame_bytes));
      const auto at = header_.data_offset + static_cast<std::uint64_t>((num_read_ + done) * frame_bytes);
      const auto got = static_cast<std::int64_t>(file_->read(at, packed_.data(), packed_.size())) / frame_bytes;
      pcm_->decode(packed_.data(), got, block.data() + done * block.cols());
      done += got;
      if (got < count) break;
    }
    return done;
  }

  [[noreturn]] void damaged(std::string_view why) const {
    refuse("container.truncated",
           fmt::format("the header promises {} frames, {} could be decoded ({}). Try --salvage to read what is there",
                       info_.num_frames, num_read_, clean_name(why)));
  }

  void describe(const SF_INFO& sound) {
    constexpr int highest_rate_hz = 100'000'000, most_channels = 1024;
    const auto codec = std::find_if(codecs.begin(), codecs.end(), [&](const Codec& known) {
      return known.subtype == (sound.format & SF_FORMAT_SUBMASK);
    });
    if (codec == codecs.end())
      refuse("container.lossy", "its codec is lossy, companded or rare; want 16, 24 or 32 bit PCM, float or FLAC");
    const double rate_hz = header_.rate_hz > 0 ? header_.rate_hz : sound.samplerate;
    if (sound.channels < 1 || sound.channels > most_channels || !(rate_hz >= 1) || rate_hz > highest_rate_hz)
      refuse("container.limit", fmt::format("{} channels at {} Hz; want 1 to {} channels at 1 to {} Hz", sound.channels,
                                            rate_hz, most_channels, highest_rate_hz));
    check_frame(sound.channels, *codec);
    info_.container = fmt::format("{}, {}", header_.container, codec->name);
    info_.sample_rate_hz = rate_hz;
    info_.num_frames = sound.frames;
    info_.columns.resize(static_cast<std::size_t>(sound.channels));
    info_.units.resize(info_.columns.size());
    info_.scaled = codec->scaled;
    if (const char* comment = sf_get_string(handle_.get(), SF_STR_COMMENT))
      info_.checks.push_back({"container.comment", "", CheckStatus::note, 0.0, 0.0, clean_name(comment)});
    if (codec->sample_bytes > 0) read_packed(sound, *codec);
  }

  // Samples that lie there one behind the other are read without what the container says of their number.
  void read_packed(const SF_INFO& sound, const Codec& codec) {
    const auto frame_bytes = static_cast<std::uint64_t>(sound.channels * codec.sample_bytes);
    const auto bytes = header_.real_size.empty() ? header_.promised_bytes : header_.present_bytes;
    info_.num_frames = static_cast<std::int64_t>(bytes / frame_bytes);
    const bool swapped = sf_command(handle_.get(), SFC_RAW_DATA_NEEDS_ENDSWAP, nullptr, 0) == SF_TRUE;
    const bool lowest_byte_first = swapped != (std::endian::native == std::endian::little);
    if (codec.scaled && codec.sample_bytes > 1 && lowest_byte_first) pcm_.emplace(codec.sample_bytes, sound.channels);
    if (pcm_) return;
    bytes_ = SoundBytes(*file_, header_.data_offset, header_.data_offset + bytes);
    SF_INFO raw{};
    raw.samplerate = sound.samplerate;
    raw.channels = sound.channels;
    raw.format = SF_FORMAT_RAW | codec.subtype | (lowest_byte_first ? SF_ENDIAN_LITTLE : SF_ENDIAN_BIG);
    open(raw);
  }

  // Samples wider than their bits are read as if their upper bits counted, which not every writer means.
  void check_frame(int channels, const Codec& codec) {
    const bool stated = header_.container != "AIFF" && codec.sample_bytes > 0;  // how far frames lie apart
    const int stated_bytes = (header_.sample_bits + 7) / 8;
    const int sample_bytes = stated_bytes > 0 ? stated_bytes : codec.sample_bytes;
    if (stated && header_.frame_bytes != static_cast<unsigned>(channels * sample_bytes))
      refuse("container.unsupported",
             fmt::format("{} channels of {} bit take {} bytes a frame, the header says {}: padded samples are not "
                         "read. Export it with packed samples",
                         channels, header_.sample_bits > 0 ? header_.sample_bits : 8 * codec.sample_bytes,
                         channels * sample_bytes, header_.frame_bytes));
    if (header_.valid_bits > 0 && header_.valid_bits < header_.sample_bits)
      info_.checks.push_back({"container.bits", "", CheckStatus::note, static_cast<double>(header_.valid_bits),
                              static_cast<double>(header_.sample_bits),
                              fmt::format("{}: {} of the {} bits of a sample count, taken to be the upper ones",
                                          file_->name(), header_.valid_bits, header_.sample_bits)});
  }

  void open(SF_INFO& sound) {
    handle_.reset(sf_open_virtual(virtual_calls<SoundBytes>(), SFM_READ, &sound, &bytes_));
    bytes_.rethrow();
    if (!handle_)
      refuse("container.damaged",
             fmt::format("{} header cannot be read: {}", header_.container, clean_name(sf_strerror(nullptr))));
  }

  [[noreturn]] void refuse(std::string name, const std::string& message) const {
    throw Fault(FaultKind::input, std::move(name), fmt::format("{}: {}", file_->name(), message));
  }

  std::unique_ptr<InputFile> file_;
  SoundHeader header_;
  bool salvage_;
  SoundBytes bytes_;
  SoundHandle handle_;  // after bytes_: closed before them
  std::int64_t num_read_ = 0;
  std::optional<PcmDecoder> pcm_;  // of what is read without the library
  std::vector<char> packed_;       // such frames, as the file holds them
};

}  // namespace

std::unique_ptr<SampleSource> open_sound_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  if (file->text(0, 4) == "fLaC") return open_flac_file(std::move(file), options);
  return std::make_unique<SoundFile>(std::move(file), options);
}

}  // namespace dsp
