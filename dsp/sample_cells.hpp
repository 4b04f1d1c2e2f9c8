#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "dsp/decimate.hpp"

namespace dsp {

/// A few successive samples of one channel: their extremes, their mean, and the largest step between neighbours, the
/// step into the first sample from the one before the cell included (0 at the start of the record).
struct SampleCell {
  double low = 0.0, high = 0.0, mean = 0.0, step = 0.0;
};

/// Cuts a stream of frames into cells that lie at multiples of `frames_per_cell` from its start, however it is cut into
/// blocks.
class CellCutter {
 public:
  CellCutter(Eigen::Index frames_per_cell, Eigen::Index num_channels);
  /// Calls on_cell(before, frames, cells) for every cell that became complete: the frame before it (at the start, its
  /// own first), its frames, one cell a channel. Throws std::invalid_argument for a value that is not finite.
  template <class OnCell>
  void push(const Eigen::Ref<const FrameBlock>& frames, const OnCell& on_cell) {
    Eigen::Index row = 0;
    while (row < frames.rows()) {
      if (num_waiting_ == 0 && frames.rows() - row >= waiting_.rows()) {
        cut(frames.middleRows(row, waiting_.rows()), on_cell);
        row += waiting_.rows();
        continue;
      }
      const auto count = std::min(waiting_.rows() - num_waiting_, frames.rows() - row);
      waiting_.middleRows(num_waiting_, count) = frames.middleRows(row, count);
      num_waiting_ += count;
      row += count;
      if (num_waiting_ == waiting_.rows()) finish(on_cell);
    }
  }
  /// The last, incomplete cell, if there is one.
  template <class OnCell>
  void finish(const OnCell& on_cell) {
    if (num_waiting_ > 0) cut(waiting_.topRows(num_waiting_), on_cell);
    num_waiting_ = 0;
  }

 private:
  using Frames = Eigen::Ref<const FrameBlock>;
  template <class OnCell>
  void cut(const Frames& frames, const OnCell& on_cell) {
    if (before_.size() == 0) before_ = frames.row(0);
    measure(frames);
    on_cell(before_, frames, cells_);
    before_ = frames.row(frames.rows() - 1);
  }
  void measure(const Frames& frames);

  FrameBlock waiting_;
  Eigen::Index num_waiting_ = 0;
  Eigen::RowVectorXd before_;  ///< the frame before the next cell; empty at the start
  std::vector<SampleCell> cells_;
};

}  // namespace dsp
