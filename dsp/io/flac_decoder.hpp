#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string_view>
#include <vector>

#include "dsp/io/flac_stream.hpp"
#include "dsp/io/input_file.hpp"

namespace dsp {

/// Samples of a FLAC from its first block on, as the file's MD5 is taken of them, which is how a WAV file holds them.
/// (RFC 9639, 9 and 10.) Takes two thirds of libsndfile's time; what is out of the ordinary is left to that.
class FlacDecoder {
 public:
  /// Files of this kind: samples of 2 or 3 bytes, with all that the head can say of blocks.
  [[nodiscard]] static bool takes(const FlacStream& stream);
  /// `file` outlives it.
  FlacDecoder(const InputFile& file, const FlacStream& stream, Eigen::Index num_channels);
  [[nodiscard]] Eigen::Index frame_bytes() const { return sample_bytes_ * std::ssize(channels_); }
  /// The next frames, one to max_frames of them: whole numbers, lowest byte first. Valid until the next call. Empty
  /// behind the last block, and where the next is not the one due, is damaged or differs in what a block may differ in.
  [[nodiscard]] std::string_view next(Eigen::Index max_frames);

 private:
  using Channel = std::vector<std::int32_t>;
  [[nodiscard]] bool decode_block();
  void read_ahead();
  void pack(std::int64_t num_frames);

  const InputFile* file_;
  FlacStream stream_;
  Eigen::Index sample_bytes_;
  std::vector<Channel> channels_;  ///< of the last block
  std::vector<char> packed_;       ///< the same
  std::size_t packed_at_ = 0, packed_end_ = 0;
  std::int64_t due_ = 0;              ///< first frame of the next block
  std::uint64_t block_at_;            ///< offset of it
  std::vector<unsigned char> ahead_;  ///< bytes of the file
  std::uint64_t ahead_at_;            ///< offset of the first
  std::size_t ahead_bytes_ = 0;       ///< of them; zeros behind
};

}  // namespace dsp
