#pragma once
#include <Eigen/Core>

namespace dsp {

/// Frames of integers of 2, 3 or 4 bytes, lowest byte first, as numbers: each is the fraction n / 2^15, n / 2^23 or
/// n / 2^31 of full scale, times the scale of its channel, plus its shift, rounded after either.
class PcmDecoder {
 public:
  /// Scales 1, shifts 0: the fractions themselves, which are exact. Throws std::invalid_argument for another width.
  PcmDecoder(int sample_bytes, Eigen::Index num_channels);
  /// One of each for every channel.
  void calibrate(const Eigen::VectorXd& scales, const Eigen::VectorXd& shifts);
  [[nodiscard]] Eigen::Index frame_bytes() const { return sample_bytes_ * num_channels_; }
  /// `values`: num_frames x num_channels, frame by frame.
  void decode(const char* bytes, Eigen::Index num_frames, double* values) const;

 private:
  int sample_bytes_;
  Eigen::Index num_channels_;
  Eigen::ArrayXd scales_, shifts_;  ///< of the samples of some frames; with the weight of the lowest bit
};

}  // namespace dsp
