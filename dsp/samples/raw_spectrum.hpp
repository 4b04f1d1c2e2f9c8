#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "dsp/filter/decimate.hpp"
#include "dsp/filter/fft.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

/// Power spectra of a long record's channels from a few segments of it, evenly spread and Hann-windowed: enough to say
/// what lies where a low-pass must stop it. Memory does not grow with the record; block sizes change nothing.
class RawSpectrum {
 public:
  static constexpr double usual_segment_s = 4.0;           ///< a window whose foot is a Hertz wide
  static constexpr Eigen::Index longest_segment = 131072;  ///< samples
  /// `num_segments`: at most. Segments are shortened to longest_segment, and to the record. Throws
  /// std::invalid_argument for a rate that is not positive, no channels or fewer than 2 segments.
  RawSpectrum(double sample_rate_hz, Eigen::Index num_channels, Eigen::Index num_frames, Eigen::Index num_segments = 8,
              double segment_s = usual_segment_s);
  /// The next frames, of num_frames in all.
  void push(const Eigen::Ref<const FrameBlock>& frames);
  /// How many of the next frames lie in no segment, and leaving out so many of them at most.
  [[nodiscard]] Eigen::Index num_idle() const;
  void skip(Eigen::Index num_frames) { num_taken_ += num_frames; }
  /// Mean of the segments: power a bin, (size / 2 + 1) x num_channels, bin k at k * rate / size, the mean taken out.
  /// No rows: the record is shorter than a segment.
  [[nodiscard]] Eigen::MatrixXd power() const;
  /// Memory that a channel takes of a record of so many frames.
  [[nodiscard]] static double bytes_per_channel(double sample_rate_hz, Eigen::Index num_frames);
  [[nodiscard]] double sample_rate_hz() const { return sample_rate_hz_; }
  [[nodiscard]] double bin_hz() const { return sample_rate_hz_ / static_cast<double>(fft_.size()); }
  /// Of each channel that moves: sample.near_nyquist (value: fraction of the power in the uppermost tenth of the band;
  /// a warning above 1 %: a recorder's own filter leaves nothing there, so what there is may have been folded already);
  /// and where a filter leads to output_rate_hz, sample.alias (value: estimated rms of what it lets fold, over the
  /// channel's: the power above half the output rate, by the rejection measured on the taps; the strongest line up
  /// there is named).
  [[nodiscard]] std::vector<Check> checks(const std::vector<Channel>& channels, double output_rate_hz,
                                          const std::optional<FilterSheet>& filter) const;

 private:
  void transform();

  double sample_rate_hz_;
  RealFft fft_;
  Eigen::VectorXd window_;
  Eigen::Index stride_ = 0, num_taken_ = 0, num_segments_ = 0;
  FrameBlock held_;      ///< of the segment under way
  Eigen::MatrixXd sum_;  ///< of power, over segments
};

}  // namespace dsp
