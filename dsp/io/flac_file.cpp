#include "dsp/io/flac_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>

#include "dsp/io/background_digest.hpp"
#include "dsp/io/flac_decoder.hpp"
#include "dsp/io/input_file.hpp"
#include "dsp/values/names.hpp"
#include "dsp/values/set_shape.hpp"

namespace dsp {
namespace {

class FlacFile : public SampleSource {
 public:
  FlacFile(std::unique_ptr<InputFile> file, const OpenOptions& options)
      : file_(std::move(file)), salvage_(options.salvage), decoder_(*file_), promised_(decoder_.stream().num_frames) {
    const auto& stream = decoder_.stream();
    if (stream.rate_hz < 1) refuse("container.limit", "0 Hz; want 1 Hz or more");
    info_.container = fmt::format("FLAC, {} bit", stream.bits);
    info_.sample_rate_hz = stream.rate_hz;
    info_.num_frames = promised_;
    info_.columns.resize(static_cast<std::size_t>(stream.num_channels));
    info_.units.resize(info_.columns.size());
    info_.scaled = true;
    if (!stream.comment.empty())
      info_.checks.push_back({"container.comment", "", CheckStatus::note, 0.0, 0.0, clean_name(stream.comment)});
    if (!stream.md5.empty()) digest_ = std::make_unique<DigestBeside>(Digest::Method::md5, options.num_threads);
    if (salvage_ || promised_ == 0)
      count_frames();
    else
      check_last_block();
  }

  Eigen::Index read(FrameBlock& block, Eigen::Index max_frames) override {
    const auto channels = static_cast<Eigen::Index>(info_.columns.size());
    const double step = std::ldexp(1.0, 1 - decoder_.stream().bits);
    set_shape(block, max_frames, channels);
    Eigen::Index got = 0;
    while (got < max_frames && num_read_ < info_.num_frames && (num_left_ > 0 || decode_block(decoder_, true))) {
      const auto& samples = decoder_.block().samples;
      const Eigen::Index count = std::min({max_frames - got, num_left_, info_.num_frames - num_read_});
      const auto* first = samples.data() + samples.size() - num_left_ * channels;
      std::transform(first, first + count * channels, block.data() + got * channels,
                     [step](std::int32_t sample) { return step * sample; });
      got += count;
      num_read_ += count;
      num_left_ -= count;
    }
    if (got < max_frames) {
      finish();
      block.conservativeResize(got, Eigen::NoChange);
    }
    return got;
  }

 private:
  // The number of the last block is known without decoding those before it.
  void check_last_block() {
    FlacDecoder last(*file_);
    last.skip_to_last_block();
    std::int64_t present = 0;
    while (last.next()) present = last.block().first + last.block().length;
    if (present == promised_) return;
    if (present == 0 || last.block().offset != file_->size())
      return warn("container.truncated", 0,
                  fmt::format("the header promises {} frames, the last of which cannot be decoded", promised_));
    refuse(name_of(present), fmt::format("the header says {} frames, {} follow it. Try --salvage to read what is there",
                                         promised_, present));
  }

  [[nodiscard]] const char* name_of(std::int64_t present) const {
    return present < promised_ ? "container.truncated" : "container.wrapped";
  }

  // Of a file that promises no count, or perhaps a wrong one.
  void count_frames() {
    FlacDecoder all(*file_);
    info_.num_frames = 0;
    while (decode_block(all, salvage_)) info_.num_frames += std::exchange(num_left_, 0);
    if (promised_ == 0) promised_ = info_.num_frames;
    if (const auto wrong = salvage_ ? sequence_fault(info_.num_frames) : std::nullopt)
      warn("container.damaged", 0, *wrong + "; it was read as it is");
    else if (info_.num_frames != promised_)
      warn(name_of(info_.num_frames), info_.num_frames,
           fmt::format("the header says {} frames, {} could be decoded; these were read", promised_, info_.num_frames));
    misplaced_.reset();
  }

  bool decode_block(FlacDecoder& decoder, bool with_digest) {
    if (!decoder.next()) return false;
    const auto& block = decoder.block();
    if (!misplaced_ && block.first != block.due) misplaced_ = place_of(block);
    num_left_ = block.filled + block.length;
    if (digest_ && with_digest) digest_samples(block.samples);
    return true;
  }

  // As FLAC defines it: whole numbers of as many bytes as they need, the lowest first.
  void digest_samples(const std::vector<std::int32_t>& samples) {
    const auto width = static_cast<std::size_t>((decoder_.stream().bits + 7) / 8);
    const auto count = samples.size();
    bytes_.resize(count * width + sizeof(std::int32_t));  // each overwrites the surplus of the one before it
    for (std::size_t i = 0; i < count; ++i) {
      const auto bits = static_cast<std::uint32_t>(samples[i]);
      const auto ordered = std::endian::native == std::endian::little ? bits : __builtin_bswap32(bits);
      std::memcpy(bytes_.data() + i * width, &ordered, sizeof ordered);
    }
    digest_->push(std::string_view(bytes_).substr(0, count * width));
  }

  void finish() {
    file_->check_unchanged();
    if (const auto wrong = salvage_ ? std::nullopt : sequence_fault(num_read_))
      refuse("container.damaged",
             *wrong + ". Copy the file from its source again, or try --salvage to read it as it is");
    if (num_read_ < info_.num_frames)
      refuse("container.truncated",
             fmt::format("the header promises {} frames, {} could be decoded. Try --salvage to read what is there",
                         info_.num_frames, num_read_));
  }

  // A block that is missing, or there twice, shifts all behind it and shows in no checksum of a block.
  std::optional<std::string> sequence_fault(std::int64_t decoded) {
    auto digest = std::exchange(digest_, nullptr);
    const bool is_of_all = digest && decoded == promised_;  // else a digest is that of other samples
    if (is_of_all && digest->finish() == decoder_.stream().md5) return std::nullopt;
    if (!is_of_all) return misplaced_;
    return "the decoded samples do not have the MD5 in its header: " +
           misplaced_.value_or(
               "its blocks follow one another, so samples were changed or the header is of another file");
  }

  [[nodiscard]] std::string place_of(const FlacDecoder::Block& block) const {
    const std::int64_t late = block.due + block.filled - block.first;
    return fmt::format("at byte {} the block of frame {} comes where frame {} is due, ", block.offset, block.first,
                       block.due) +
           (late == 0
                ? "with zeros in place of what is missing"
                : fmt::format("so that what follows is {} frames ({:.4g} s) {}", std::abs(late),
                              static_cast<double>(std::abs(late)) / info_.sample_rate_hz, late > 0 ? "late" : "early"));
  }

  void warn(std::string name, std::int64_t present, const std::string& message) {
    info_.checks.push_back({std::move(name), "", CheckStatus::warning, static_cast<double>(present),
                            static_cast<double>(promised_), fmt::format("{}: {}", file_->name(), message)});
  }

  [[noreturn]] void refuse(std::string name, const std::string& message) const {
    throw Fault(FaultKind::input, std::move(name), fmt::format("{}: {}", file_->name(), message));
  }

  std::unique_ptr<InputFile> file_;
  bool salvage_;
  FlacDecoder decoder_;
  std::int64_t promised_;  // frames
  std::int64_t num_read_ = 0;
  Eigen::Index num_left_ = 0;  // frames of the decoded block that are not read yet
  std::unique_ptr<DigestBeside> digest_;
  std::optional<std::string> misplaced_;  // the first block that was not the one due
  std::string bytes_;
};

}  // namespace

std::unique_ptr<SampleSource> open_flac_file(std::unique_ptr<InputFile> file, const OpenOptions& options) {
  return std::make_unique<FlacFile>(std::move(file), options);
}

}  // namespace dsp
