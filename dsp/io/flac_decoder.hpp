#pragma once
#include <FLAC/stream_decoder.h>

#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <vector>

namespace dsp {

class InputFile;

/// A FLAC file block by block, by libFLAC. "Frame" means one sample of every channel, as everywhere here; what libFLAC
/// calls a frame is a block. Blocks that are damaged are left out, and silence takes the place of up to 32 missing.
class FlacDecoder {
 public:
  /// What the head of the file says.
  struct Stream {
    std::int64_t num_frames = 0;  ///< 0: not known
    int num_channels = 0, bits = 0;
    double rate_hz = 0.0;
    std::uint64_t longest_block = std::uint64_t{1} << 22;  ///< bytes; as said, or more than there can be
    std::string md5, comment;                              ///< 16 bytes, of the decoded samples; empty: not known
  };
  struct Block {
    std::uint64_t offset = 0;             ///< bytes
    std::int64_t first = 0, due = 0;      ///< its first frame as it says itself, and as the block before has it
    std::int64_t filled = 0, length = 0;  ///< frames of silence, and its own behind them
    std::vector<std::int32_t> samples;    ///< of these, frame by frame
  };
  /// The file must outlive it. Throws Fault container.damaged (input) where the head is cut or makes no sense.
  explicit FlacDecoder(const InputFile& file);
  FlacDecoder(const FlacDecoder&) = delete;  // libFLAC knows where it is
  FlacDecoder& operator=(const FlacDecoder&) = delete;
  [[nodiscard]] const Stream& stream() const& { return stream_; }
  void stream() const&& = delete;
  /// Leaves out all but the file's last bytes, in which the last block begins.
  void skip_to_last_block();
  /// Makes block() the next; false at the end. Throws Fault file.read.
  bool next();
  [[nodiscard]] const Block& block() const& { return block_; }
  void block() const&& = delete;
  [[nodiscard]] std::uint64_t offset() const;  ///< where what is not decoded yet begins, in bytes

 private:
  struct Calls;
  void rethrow() const;
  const InputFile* file_;
  std::uint64_t position_ = 0;  ///< of what the decoder reads next
  Stream stream_;
  Block block_;
  std::exception_ptr error_;  ///< kept from libFLAC, which is C
  std::unique_ptr<FLAC__StreamDecoder, void (*)(FLAC__StreamDecoder*)> decoder_;
};

}  // namespace dsp
