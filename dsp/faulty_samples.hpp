#pragma once
#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "dsp/decimate.hpp"
#include "dsp/recording.hpp"

namespace dsp {

enum class SampleFault {
  clipped,  ///< stands at the limit of what the channel can show
  dropout,  ///< jumped to zero or beyond everything else the channel shows, and stays there
  held,     ///< one value repeated although the channel had always moved
};
[[nodiscard]] std::string_view to_string(SampleFault fault);

/// Frames [first, last) of one channel.
struct FaultyStretch {
  Eigen::Index channel = 0;
  SampleFault fault = SampleFault::clipped;
  Eigen::Index first = 0, last = 0;
  double level = 0.0;  ///< where it stands, in the channel's unit
};

struct SampleFaults {
  std::vector<FaultyStretch> stretches;  ///< by channel, then time
  std::vector<Interval> bad;             ///< the same in seconds, with reasons; margins not added
  std::vector<Check> checks;             ///< see below
};

/// What a channel can show, in its own unit.
struct ChannelLimits {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
};

struct FaultySampleOptions {
  std::vector<ChannelLimits> limits = {};  ///< one a channel; empty: none known
  double limit_tolerance = 5e-4;           ///< of a known limit: 3.998 of 4 V counts as 4 V
  int held_updates = 40;                   ///< so many updates of a channel without a change are a fault
  double max_held_fraction = 0.05;  ///< where more of a record than this stands still, standing still is no fault
  double merge_gap_s = 0.05;        ///< stretches closer than this become one
};

/// Finds the samples of simultaneous channels that show something else than what was measured, block by block, in
/// memory that does not grow with the record but for the stretches found. Block sizes do not change the result.
///
/// A channel is looked at in cells of 1.25 ms (one sample below 800 Hz). It stands still in a cell if no step from one
/// sample to the next is larger than a floor. The floor is 0, equal values, unless the channel repeats its values for a
/// while with noise on top, as a laser behind a converter does: then nine steps in ten are small and every cell has a
/// large one, and the floor is 8 times the median step. How long the channel stands still as a rule (a laser: one
/// update) is learnt from the record; forty times as long is a fault where it is rare, or where it ends in a jump that
/// the channel does not make elsewhere.
///
/// Clipped is, first, what lies at a limit that is known. Secondly, without one, what equals the record's extreme
/// value, if that value occurs at least ten times, twice or more in a row, and five times as often as the next lower
/// value seen, which no smooth maximum does (2.4 at most). Extreme and count start anew with every more extreme value.
/// Thirdly, eight cells of standing still beyond all that the moving channel shows, to 1/1000 of its range.
///
/// checks, one a channel: sample.clipped (value: share of samples), sample.dropout, sample.held (value: seconds),
/// sample.spike (value: how many; they stay), sample.constant, sample.quantised (value: effective bits), sample.offset
/// (value: mean), sample.drift (value: of a line through the record, from end to end), sample.repeated (value: seconds
/// for which each value is repeated as a rule). Never a Fault: what to refuse depends on what the channel is for.
class FaultySamples {
 public:
  /// Throws std::invalid_argument for a rate that is not positive, no channels, or limits of another number.
  FaultySamples(double sample_rate_hz, std::vector<Channel> channels, const FaultySampleOptions& options = {});
  ~FaultySamples();
  FaultySamples(FaultySamples&&) noexcept;
  FaultySamples& operator=(FaultySamples&&) noexcept;
  /// Any number of frames. Throws std::invalid_argument for a wrong number of columns or a value that is not finite
  /// (RecordingReader bridges those, and marks them).
  void push(const Eigen::Ref<const FrameBlock>& frames);
  /// No more frames: what was found.
  [[nodiscard]] SampleFaults finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct FillOptions {
  double max_gap_s = 1.0;   ///< longer gaps are bridged by a straight line
  Eigen::Index order = 64;  ///< of the predictors
  double fit_s = 4.0;       ///< of the signal on either side that they are fitted to
};

/// Replaces the samples inside each gap (seconds from the first sample) by a prediction from before and one, backwards,
/// from after, faded into each other; nothing outside changes. Meant for the bus, where a predictor reaches over a
/// cycle: widen the gap by what the filter before it smears (23.6 ms down to 256 Hz). Gaps that touch are one; at an
/// end of the record there is one prediction. Throws std::invalid_argument if nothing is left to predict from.
void fill_gaps(Eigen::Ref<Eigen::VectorXd> samples, double sample_rate_hz, std::vector<Interval> gaps,
               const FillOptions& options = {});

}  // namespace dsp
