#pragma once
#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "dsp/filter/decimate.hpp"
#include "dsp/values/recording.hpp"

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
  std::vector<int> hold_samples;    ///< of each channel: HoldLength
};

/// What a channel can show, in its own unit.
struct ChannelLimits {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
};

struct FaultySampleOptions {
  std::vector<ChannelLimits> limits = {};  ///< one a channel; empty: none known
  double limit_tolerance = 5e-4;           ///< of a known limit: 3.998 of 4 V counts as 4 V
  int held_updates = 40;                   ///< so many updates of a channel without a change are a problem
  double max_held_fraction = 0.05;  ///< where more of a record than this stands still, standing still is no problem
  double merge_gap_s = 0.05;        ///< ranges closer than this become one
};

/// Finds the samples of simultaneous channels that show something else than what was measured, block by block, in
/// memory that does not grow with the record but for the ranges found. Block sizes do not change the result.
///
/// A channel is looked at in cells of 1.25 ms (one sample below 800 Hz). It stands still in a cell if no step from one
/// sample to the next is larger than a floor. The floor is 0, equal values, unless the channel repeats its values for a
/// while with noise on top, as a laser behind a converter does: then four steps in five at least are small, every other
/// cell at least has a large one, and the floor is 8 times the median step. How long the channel stands still as a rule
/// (a laser: one update) is learnt from the record. Faulty is
/// - forty times as long, if that is rare and begins or ends at full pace, or ends in a jump, that is a step eight
///   times as large as the usual ones and as those next to it;
/// - four cells (64 samples) of equal values, if equal values are rare and it begins or ends at full pace;
/// - eight cells (16 samples) at zero or at the extremes of the record, after a jump.
/// What comes to rest by degrees, as friction or rounding have it, is none.
///
/// Clipped is, first, what lies at a limit that is known, two samples or more in a row. Secondly, without one, what
/// equals the record's extreme value, if that value occurs at least ten times, on three visits that skip the next
/// value, and eight times as often as the next lower value seen, which no smooth maximum does (2.4 at most). Extreme
/// and count start anew with every more extreme value. A record that spends 30 % at it rests there. Thirdly, where
/// noise lies on repeated values, levels of the outermost 1/512 of the range that are met while standing still and four
/// times as often as those next to them, if one such range lasts eight cells and is reached at a pace of three steps
/// of the sensor a cell; then every crest that gets there is clipped, however short. A clipped range that has no other
/// like it and noise on top is not found.
///
/// checks, one a channel: sample.clipped (value: fraction of samples), sample.dropout, sample.held (value: seconds),
/// sample.spike (value: how many; they stay), sample.offset (value: mean), sample.drift (value: of a line through the
/// record, from end to end); where they apply sample.constant (then nothing else), sample.quantised (value: effective
/// bits), sample.repeated (value: seconds for which a value is repeated on average). A channel of at most eight values
/// is a switch and has no faults. Never a Fault: what to refuse depends on what the channel is for.
class FaultySamples {
 public:
  /// Throws std::invalid_argument for a rate that is not positive, no channels, or limits of another number.
  FaultySamples(double sample_rate_hz, std::vector<Channel> channels, const FaultySampleOptions& options = {});
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
