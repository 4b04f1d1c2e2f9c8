#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "dsp/filter/decimate.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

/// Makes values missing (NaN) that stand alone, far from those around them, as sensors write where they fail (-9999,
/// 65535, the zero or the far wall of an ultrasonic ranger): up to three in a row, each farther from the values on
/// either side than ten times what three steps in four of their neighbourhood and of the record stay below. Masses do
/// not jump there and back, so any such value of a displacement or velocity is none; of other channels, in which a
/// shock may show so, those of which at least three are one and the same number. Frames leave some thousand later than
/// they came; block sizes change nothing.
class IsolatedValues {
 public:
  IsolatedValues(const std::vector<Channel>& channels, double sample_rate_hz);
  /// Takes frames; returns those that are decided, often none.
  [[nodiscard]] FrameBlock push(const FrameBlock& frames);
  /// No more will come: the rest.
  [[nodiscard]] FrameBlock finish();
  /// sample.isolated of each channel that had any (value: how many).
  [[nodiscard]] std::vector<Check> checks() const;

 private:
  struct Found {
    std::int64_t count = 0, first = 0;
    double level = 0.0;
  };
  void decide(Eigen::Index channel, Eigen::Index last, Eigen::Index num_seen);
  void decide(Eigen::Index last, Eigen::Index num_seen, FrameBlock& leaving);

  std::vector<Channel> channels_;
  double sample_rate_hz_;
  std::vector<Found> found_;  // of each channel
  FrameBlock held_;           // the first decided_ rows have left
  Eigen::Index decided_ = 0;
  std::int64_t first_ = 0;  // frame of the first row of held_
};

}  // namespace dsp
