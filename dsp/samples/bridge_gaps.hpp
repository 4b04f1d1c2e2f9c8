#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "dsp/filter/decimate.hpp"
#include "dsp/values/recording.hpp"

namespace dsp {

struct BridgeOptions {
  std::string name;                   ///< of the recording, for messages
  std::vector<std::string> channels;  ///< names
  double sample_rate_hz = 0.0;
  std::size_t max_memory_bytes = std::size_t{4} << 30;
};

/// Streams frames through and replaces what is missing (NaN, infinite) by straight lines between its neighbours, up to
/// three samples by a parabola through the one before these, too, or by the nearest value at the ends of the recording.
/// Frames leave once nothing in them is open, or as many are held as fit into 128 MB; block sizes change nothing. What
/// lacks before the first value of a channel is no gap: its sensor was not on yet. Each frame is moved or copied once
/// on its way in and once on its way out, however many are held. Throws Fault (input): sample.missing where a channel
/// begins too late for what is held of the others until then, or never; sample.huge for a value beyond 1e100, whose
/// square would not fit; memory.limit (numerics).
class GapBridge {
 public:
  explicit GapBridge(BridgeOptions options);
  /// Takes frames; they may leave at once or later.
  void push(FrameBlock frames);
  /// Memory that is taken beside what is held until a late channel begins; counted with it.
  void set_bytes_beside(double bytes) { bytes_beside_ = bytes; }
  /// No more frames will come.
  void finish();
  [[nodiscard]] Eigen::Index num_ready() const;
  /// Makes `block` the next frames, at most max_frames of those ready; returns how many.
  Eigen::Index take(FrameBlock& block, Eigen::Index max_frames);
  /// The intervals bridged so far, and a warning per channel that had any.
  [[nodiscard]] const std::vector<Interval>& bridged() const& { return bridged_; }
  void bridged() const&& = delete;
  [[nodiscard]] std::vector<Check> checks() const;

 private:
  struct Open {
    std::int64_t first = -1;  ///< first missing frame, -1: nothing open
    double before = 0.0;      ///< last value there was
    double earlier = 0.0;     ///< the value before that
    bool has_before = false, has_earlier = false;
    std::int64_t num_before = 0;   ///< missing before the first value
    std::int64_t num_missing = 0;  ///< behind it
    std::int64_t num_gaps = 0;
    double first_place_s = 0.0;
  };
  /// Frames from `first` on.
  struct Held {
    std::int64_t first = 0;
    FrameBlock frames;
  };
  void check_channel(Eigen::Index channel, bool are_values);
  [[nodiscard]] bool are_many_held(std::int64_t num_held) const;
  void require_begin(Eigen::Index channel, std::int64_t num_held) const;
  void close(Eigen::Index channel, std::int64_t end, double behind, bool has_behind);

  BridgeOptions options_;
  std::vector<Open> open_;
  std::deque<Held> held_;             ///< frames [first_, end_) are those that have not left
  std::int64_t first_ = 0, end_ = 0;  ///< first_ may be amid the first block
  double bytes_beside_ = 0.0;
  std::vector<Interval> bridged_;
};

}  // namespace dsp
