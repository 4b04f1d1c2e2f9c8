#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "dsp/filter/decimate.hpp"
#include "dsp/samples/faulty_samples.hpp"
#include "dsp/samples/raw_spectrum.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

/// Takes a recording block by block and keeps it at the intermediate rate: memory grows with the samples there only.
/// Block sizes do not change a bit of the result.
class IntermediateRecorder {
 public:
  /// `description`: name, rate and channels of what will be pushed, num_frames of it. No options: kept at its own rate.
  /// Throws std::invalid_argument as Decimator does.
  IntermediateRecorder(const Recording& description, Eigen::Index num_frames,
                       const std::optional<DecimateOptions>& options);
  ~IntermediateRecorder();
  /// Throws Fault sample.missing (input) for a sample that is not finite.
  void push(const Eigen::Ref<const FrameBlock>& frames);
  /// The samples at the intermediate rate, under the description given, with what was found faulty in `bad` and
  /// `checks`, and there filled by prediction from both sides.
  [[nodiscard]] Recording finish();
  /// Where samples were found faulty, in frames of the recording; known after finish().
  [[nodiscard]] const std::vector<FaultyRange>& faulty_ranges() const& { return faulty_ranges_; }
  void faulty_ranges() const&& = delete;
  /// Of the recording, once all is pushed.
  [[nodiscard]] const RawSpectrum& spectrum() const& { return spectrum_; }
  void spectrum() const&& = delete;
  /// Of the filter from the recording to the intermediate rate; none when there is none.
  [[nodiscard]] std::optional<FilterSheet> sheet() const;

 private:
  void keep(const FrameBlock& frames);
  void refuse(const Eigen::Ref<const FrameBlock>& frames) const;
  void fill();
  void take_held(Channel& channel, int samples);

  Recording recording_;
  double input_rate_hz_ = 0.0;
  FaultySamples faulty_;
  RawSpectrum spectrum_;
  std::optional<Decimator> decimator_;
  std::vector<FaultyRange> faulty_ranges_;
  Eigen::Index num_taken_ = 0, num_kept_ = 0;
};

}  // namespace dsp
