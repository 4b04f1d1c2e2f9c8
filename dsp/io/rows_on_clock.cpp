#include "dsp/io/rows_on_clock.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/samples/short_gap.hpp"
#include "dsp/values/set_shape.hpp"

namespace dsp {

void RowsOnClock::set_clock(Clock clock) {
  clock_ = std::move(clock);
  info_.sample_rate_hz = clock_.rate_hz;
  info_.clock_start.s = clock_.start_s;
  info_.num_frames = clock_.num_frames;
  info_.gaps = clock_.gaps;
  info_.checks.insert(info_.checks.end(), clock_.checks.begin(), clock_.checks.end());
}

double RowsOnClock::position(std::int64_t row) const {
  return clock_.position[static_cast<std::size_t>(row)];
}

Eigen::Index RowsOnClock::read(FrameBlock& block, Eigen::Index max_frames) {
  const auto width = static_cast<Eigen::Index>(info_.columns.size());
  const auto count = static_cast<Eigen::Index>(std::min<std::int64_t>(max_frames, info_.num_frames - next_frame_));
  set_shape(block, count, width);
  earlier_.resize(width);
  before_.resize(width);
  behind_.resize(width);
  const bool is_frame = clock_.position.empty();  // each row
  for (Eigen::Index i = 0; i < count; ++i, ++next_frame_) {
    if (is_frame) {
      read_row(behind_);
      block.row(i) = behind_;
      continue;
    }
    const auto at = static_cast<double>(next_frame_);
    while (next_row_ == 0 || position(next_row_ - 1) < at) {
      earlier_.swap(before_);
      before_.swap(behind_);
      read_row(behind_);
      ++next_row_;
    }
    const double behind = position(next_row_ - 1);
    if (behind == at) {
      block.row(i) = behind_;
    } else {
      const double before = position(next_row_ - 2), fraction = (at - before) / (behind - before);
      block.row(i) = (1 - fraction) * before_ + fraction * behind_;
      const bool is_lost_row = before == std::round(before) && behind == std::round(behind);
      if (next_row_ > 2 && is_lost_row && is_curved_gap(behind - before)) {
        const double earlier = position(next_row_ - 3) - before, steps = behind - before;
        block.row(i) +=
            parabola(earlier, steps, at - before) * (earlier_ - before_ - earlier / steps * (behind_ - before_));
      }
    }
  }
  if (count == 0 && max_frames > 0) finish_reading();
  return count;
}

}  // namespace dsp
