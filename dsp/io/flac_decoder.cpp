#include "dsp/io/flac_decoder.hpp"

#include <fmt/format.h>
#include <strings.h>

#include <algorithm>
#include <iterator>
#include <new>
#include <string_view>

#include "dsp/io/input_file.hpp"
#include "dsp/values/fault.hpp"

namespace dsp {

// What libFLAC calls.
struct FlacDecoder::Calls {
  static FlacDecoder& of(void* self) { return *static_cast<FlacDecoder*>(self); }

  template <class Work>
  static bool succeeds(FlacDecoder& self, Work work) {
    try {
      work();
      return true;
    } catch (...) {
      self.error_ = std::current_exception();
      return false;
    }
  }

  static FLAC__StreamDecoderReadStatus read(const FLAC__StreamDecoder* /*decoder*/, FLAC__byte* into,
                                            std::size_t* count, void* client) {
    FlacDecoder& self = of(client);
    if (!succeeds(self, [&] { *count = self.file_->read(self.position_, into, *count); }))
      return FLAC__STREAM_DECODER_READ_STATUS_ABORT;
    // The count of frames is 36 bits, here 0, not known: else libFLAC stops there, whatever follows.
    constexpr std::uint64_t count_at = 21, count_end = 26;
    for (auto at = std::max(self.position_, count_at); at < std::min(self.position_ + *count, count_end); ++at)
      into[at - self.position_] &= at == count_at ? 0xf0 : 0;
    self.position_ += *count;
    return *count == 0 ? FLAC__STREAM_DECODER_READ_STATUS_END_OF_STREAM : FLAC__STREAM_DECODER_READ_STATUS_CONTINUE;
  }

  static FLAC__StreamDecoderTellStatus tell(const FLAC__StreamDecoder* /*decoder*/, FLAC__uint64* offset,
                                            void* client) {
    *offset = of(client).position_;
    return FLAC__STREAM_DECODER_TELL_STATUS_OK;
  }

  // Several calls for one block: silence for those that are missing before it.
  static FLAC__StreamDecoderWriteStatus write(const FLAC__StreamDecoder* /*decoder*/, const FLAC__Frame* frame,
                                              const FLAC__int32* const* channels, void* client) {
    FlacDecoder& self = of(client);
    const FLAC__FrameHeader& head = frame->header;
    const auto count = static_cast<unsigned>(self.stream_.num_channels);
    if (head.channels != count || head.bits_per_sample != static_cast<unsigned>(self.stream_.bits))
      return FLAC__STREAM_DECODER_WRITE_STATUS_ABORT;
    self.block_.first = static_cast<std::int64_t>(head.number.sample_number);
    self.block_.filled += self.block_.length;
    self.block_.length = head.blocksize;
    auto& samples = self.block_.samples;
    const auto put = [&] {
      const std::size_t begin = samples.size();
      samples.resize(begin + std::size_t{head.blocksize} * count);
      for (unsigned c = 0; c < count; ++c) {
        auto* to = samples.data() + begin + c;
        for (unsigned i = 0; i < head.blocksize; ++i, to += count) *to = channels[c][i];
      }
    };
    return succeeds(self, put) ? FLAC__STREAM_DECODER_WRITE_STATUS_CONTINUE : FLAC__STREAM_DECODER_WRITE_STATUS_ABORT;
  }

  static void describe(const FLAC__StreamDecoder* /*decoder*/, const FLAC__StreamMetadata* data, void* client) {
    FlacDecoder& self = of(client);
    Stream& stream = self.stream_;
    if (data->type == FLAC__METADATA_TYPE_STREAMINFO && stream.bits == 0) {
      const auto& info = data->data.stream_info;
      stream.num_channels = static_cast<int>(info.channels);
      stream.bits = static_cast<int>(info.bits_per_sample);
      stream.rate_hz = info.sample_rate;
      if (info.max_framesize > 0) stream.longest_block = info.max_framesize;
      (void)succeeds(self, [&] { stream.md5.assign(std::begin(info.md5sum), std::end(info.md5sum)); });
    }
    constexpr std::string_view key = "COMMENT=";
    const auto& texts = data->data.vorbis_comment;
    for (unsigned i = 0; data->type == FLAC__METADATA_TYPE_VORBIS_COMMENT && i < texts.num_comments; ++i) {
      const std::string_view text(reinterpret_cast<const char*>(texts.comments[i].entry), texts.comments[i].length);
      if (text.size() > key.size() && ::strncasecmp(text.data(), key.data(), key.size()) == 0)
        (void)succeeds(self, [&] { stream.comment = text.substr(key.size()); });
    }
  }

  static void fail(const FLAC__StreamDecoder* /*decoder*/, FLAC__StreamDecoderErrorStatus /*status*/,
                   void* /*client*/) {
    // It shows in the blocks: they are not there.
  }
};

FlacDecoder::FlacDecoder(const InputFile& file)
    : file_(&file), decoder_(FLAC__stream_decoder_new(), FLAC__stream_decoder_delete) {
  if (!decoder_) throw std::bad_alloc();
  FLAC__stream_decoder_set_metadata_respond(decoder_.get(), FLAC__METADATA_TYPE_VORBIS_COMMENT);
  const bool begun = FLAC__stream_decoder_init_stream(decoder_.get(), Calls::read, nullptr, Calls::tell, nullptr,
                                                      nullptr, Calls::write, Calls::describe, Calls::fail,
                                                      this) == FLAC__STREAM_DECODER_INIT_STATUS_OK &&
                     FLAC__stream_decoder_process_until_end_of_metadata(decoder_.get()) != 0;
  if (error_) std::rethrow_exception(error_);
  // The library finds no memory for a block that claims more than it has: such a header is damaged, too.
  const std::string count = file.text(21, 5);
  if (!begun || stream_.bits == 0 ||
      FLAC__stream_decoder_get_state(decoder_.get()) >= FLAC__STREAM_DECODER_END_OF_STREAM)
    throw Fault(FaultKind::input, "container.damaged",
                fmt::format("{}: the FLAC header is cut at byte {}, or damaged", file.name(), file.size()));
  for (const char byte : count) stream_.num_frames = stream_.num_frames << 8 | static_cast<unsigned char>(byte);
  stream_.num_frames &= 0xfffffffff;
  if (stream_.md5.find_first_not_of('\0') == std::string::npos) stream_.md5.clear();
}

void FlacDecoder::rethrow() const {
  if (error_) std::rethrow_exception(error_);
  if (FLAC__stream_decoder_get_state(decoder_.get()) == FLAC__STREAM_DECODER_MEMORY_ALLOCATION_ERROR)
    throw std::bad_alloc();
}

std::uint64_t FlacDecoder::offset() const {
  FLAC__uint64 offset = 0;
  return FLAC__stream_decoder_get_decode_position(decoder_.get(), &offset) != 0 ? offset : position_;
}

void FlacDecoder::skip_to_last_block() {
  constexpr std::uint64_t tag_bytes = 4096;  // behind it
  position_ = std::max(offset(), file_->size() - std::min(stream_.longest_block + tag_bytes, file_->size()));
  if (FLAC__stream_decoder_flush(decoder_.get()) == 0) throw std::bad_alloc();
}

bool FlacDecoder::next() {
  block_.due = block_.first + block_.length;
  block_.offset = offset();
  block_.filled = block_.length = 0;
  block_.samples.clear();
  while (block_.samples.empty() &&
         FLAC__stream_decoder_get_state(decoder_.get()) < FLAC__STREAM_DECODER_END_OF_STREAM &&
         FLAC__stream_decoder_process_single(decoder_.get()) != 0)
    continue;
  rethrow();
  return !block_.samples.empty();
}

}  // namespace dsp
