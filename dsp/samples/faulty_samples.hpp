#pragma once
#include <Eigen/Core>
#include <memory>
#include <string_view>
#include <vector>

#include "dsp/decimate.hpp"
#include "dsp/recording.hpp"

namespace dsp {

enum class SampleFault {
  clipped,  ///< is at the limit of what the channel can show
  dropout,  ///< jumped to zero or beyond everything else the channel shows, and stays there
  held,     ///< one value repeated where the channel had moved
};
[[nodiscard]] std::string_view to_string(SampleFault fault);

/// Frames [first, last) of one channel.
struct FaultyRange {
  Eigen::Index channel = 0;
  SampleFault fault = SampleFault::clipped;
  Eigen::Index first = 0, last = 0;
  double level = 0.0;  ///< where it is, in the channel's unit
};

struct SampleFaults {
  std::vector<FaultyRange> ranges;  ///< by channel, then time
  std::vector<Interval> bad;        ///< the same in seconds, with reasons; margins not added
  std::vector<Check> checks;        ///< see below
};

/// Finds the samples of simultaneous channels that show something else than what was measured, block by block, in
/// memory that does not grow with the record but for the ranges found. Block sizes do not change the result.
///
/// A channel is looked at in cells of 1.25 ms (one sample below 800 Hz). It stands still in a cell if no step from one
/// sample to the next is larger than a floor: 0, equal values, unless the channel repeats its values for a while with
/// noise on top, as a laser behind a converter does (StepScale). A run of still cells is a fault where it is
/// - too long for chance (RunLengths), and
/// - cut: left or reached over two cells by more than what comes to rest by degrees leaves or reaches.
/// At zero or at the extremes of the record, after a jump, it is a dropout; a crest cut off at an extreme is clipped;
/// else it is held. Clipped is, besides, what lies at the end of the channel's range, and what lies at the edge of the
/// histogram of its values where they pile up (HistogramEdge); a record that spends 30 % there rests there.
///
/// checks, one a channel: sample.clipped (value: fraction of samples), sample.dropout, sample.held (value: seconds),
/// sample.spike (value: how many; they stay), sample.offset (value: mean), sample.drift (value: of a line through the
/// record, from end to end); where they apply sample.constant (then nothing else), sample.quantised (value: effective
/// bits), sample.repeated (value: seconds for which a value is repeated on average). A channel of at most eight values
/// is a switch and has no faults. Never a Fault: what to refuse depends on what the channel is for.
class FaultySamples {
 public:
  /// Ranges closer than merge_gap_s become one. Throws std::invalid_argument for a rate that is not positive or no
  /// channels.
  FaultySamples(double sample_rate_hz, std::vector<Channel> channels, double merge_gap_s = 0.05);
  ~FaultySamples();
  /// Memory that a channel takes of a record of so many frames, but for the stretches found.
  [[nodiscard]] static double bytes_per_channel(double sample_rate_hz, Eigen::Index num_frames);
  /// Any number of frames. Throws std::invalid_argument for a wrong number of columns or a value that is not finite
  /// (RecordingReader bridges those, and marks them).
  void push(const Eigen::Ref<const FrameBlock>& frames);
  /// No more frames: what was found.
  [[nodiscard]] SampleFaults finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace dsp
