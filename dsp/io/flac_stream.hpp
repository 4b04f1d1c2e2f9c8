#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "dsp/decimate.hpp"
#include "dsp/io/input_file.hpp"

namespace dsp {

/// What the head of a FLAC file says of its samples (STREAMINFO; RFC 9639, 8.2). "Frame" means one sample of every
/// channel, as everywhere here; what the RFC calls a frame is a block.
struct FlacStream {
  std::int64_t num_frames = 0;      ///< 0: not known
  int bits = 0;                     ///< of a sample
  std::int64_t block_frames = 0;    ///< of every block but the last, 0: they differ
  std::uint64_t longest_block = 0;  ///< bytes, 0: not known
  std::uint64_t first_block = 0;    ///< offset in bytes
  std::string md5;                  ///< 16 bytes, of the decoded samples; empty: not known
};
/// Throws Fault container.damaged (input) where the head is cut.
[[nodiscard]] FlacStream flac_stream(const InputFile& file);

/// How many frames there are by the number of the last block, whole by its checksum. Looked up in the file's last
/// bytes: a decoder's seek takes as long as decoding half the record. Nothing where the file does not end in a block.
[[nodiscard]] std::optional<std::int64_t> frames_by_last_block(const InputFile& file, const FlacStream& stream);

/// A block that is not the one due: others are missing before it, or it comes again.
struct MisplacedBlock {
  std::uint64_t offset = 0;         ///< bytes
  std::int64_t found = 0, due = 0;  ///< first frames
};
/// The first of them; nothing where all blocks follow one another.
[[nodiscard]] std::optional<MisplacedBlock> misplaced_block(const InputFile& file, const FlacStream& stream);

/// MD5 over decoded samples as FLAC defines it, at some 600 MB/s of them; with num_threads > 1 on a thread of its own.
class FlacDigest {
 public:
  explicit FlacDigest(int bits, int num_threads = 1);
  ~FlacDigest();
  FlacDigest(FlacDigest&&) noexcept;
  /// Fractions of full scale, in the order of the file; any number of frames at a time.
  void push(const double* samples, std::size_t count);
  /// 16 bytes; nothing can be pushed afterwards.
  [[nodiscard]] std::string finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace dsp
