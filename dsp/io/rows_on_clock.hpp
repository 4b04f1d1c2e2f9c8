#pragma once
#include "dsp/io/sample_source.hpp"
#include "dsp/io/table_clock.hpp"

namespace dsp {

/// Frames on an even grid from rows that lie on it somehow: rows as they are where they meet a frame, straight lines
/// between the rows around it elsewhere, or where a few rows are lost, a parabola through the row before, too.
class RowsOnClock : public SampleSource {
 public:
  Eigen::Index read(FrameBlock& block, Eigen::Index max_frames) final;

 protected:
  /// The next row, as wide as there are columns.
  virtual void read_row(Eigen::RowVectorXd& row) = 0;
  /// Called when all frames have been read.
  virtual void finish_reading() = 0;
  /// Rate, start, frames, gaps and checks from a clock, before the first read.
  void set_clock(Clock clock);

 private:
  [[nodiscard]] double position(std::int64_t row) const;

  Clock clock_;
  Eigen::RowVectorXd earlier_, before_, behind_;  // the rows around the next frame, and the one before
  std::int64_t next_row_ = 0, next_frame_ = 0;
};

}  // namespace dsp
