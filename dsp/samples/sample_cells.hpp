#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <vector>

#include "dsp/filter/decimate.hpp"

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
  /// Calls on_cells(before, frames, cells) for the cells that became complete, some hundred at a time: the frame before
  /// them (at the start, their own first), their frames, and the cells, those of the first channel first. Throws
  /// std::invalid_argument for a value that is not finite.
  template <class OnCells>
  void push(const Eigen::Ref<const FrameBlock>& frames, const OnCells& on_cells) {
    const Eigen::Index cell = waiting_.rows();
    for (Eigen::Index row = 0, count = 0; row < frames.rows(); row += count) {
      const Eigen::Index left = frames.rows() - row;
      if (num_waiting_ == 0 && left >= cell) {
        count = std::min(left / cell, most_cells) * cell;
        cut(frames.middleRows(row, count), on_cells);
      } else {
        count = std::min(cell - num_waiting_, left);
        waiting_.middleRows(num_waiting_, count) = frames.middleRows(row, count);
        num_waiting_ += count;
        if (num_waiting_ == cell) finish(on_cells);
      }
    }
  }
  /// The last, incomplete cell, if there is one.
  template <class OnCells>
  void finish(const OnCells& on_cells) {
    if (num_waiting_ > 0) cut(waiting_.topRows(num_waiting_), on_cells);
    num_waiting_ = 0;
  }

 private:
  using Frames = Eigen::Ref<const FrameBlock>;
  static constexpr Eigen::Index most_cells = 256;
  template <class OnCells>
  void cut(const Frames& frames, const OnCells& on_cells) {
    if (before_.size() == 0) before_ = frames.row(0);
    measure(frames);
    on_cells(before_, frames, std::span<const SampleCell>(cells_));
    before_ = frames.row(frames.rows() - 1);
  }
  void measure(const Frames& frames);

  FrameBlock waiting_;
  Eigen::Index num_waiting_ = 0;
  Eigen::RowVectorXd before_;  ///< the frame before the next cell; empty at the start
  std::vector<SampleCell> cells_;
};

}  // namespace dsp
