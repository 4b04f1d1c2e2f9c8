#include "dsp/samples/clipping.hpp"

#include <algorithm>
#include <cmath>

namespace dsp {

void SampleRanges::add(Eigen::Index first, Eigen::Index count) {
  run_ = !list_.empty() && first == list_.back().last ? run_ + count : count;
  longest_ = std::max(longest_, run_);
  if (list_.empty() || first - list_.back().last > merge_gap_)
    list_.push_back({first, first + count});
  else
    list_.back().last = first + count;
}

void HistogramEdge::set_width(double width) {
  constexpr double much = 1.5;  // it is learnt anew now and then
  if (width <= much * width_) return;
  width_ = width;
  edge_ = next_ = none;
  at_limit_.clear();
  at_edge_.clear();
}

void HistogramEdge::look(double value, Eigen::Index first, Eigen::Index count) {
  is_away_ = is_away_ || first != looked_at_;
  looked_at_ = first + count;
  if (value >= limit_) at_limit_.add(first, count);
  const double same = width_ + 1e-9 * std::abs(value);  // but for rounding
  if (value > edge_ + same) {
    next_ = edge_;
    next_count_ = count_;
    edge_ = value;
    count_ = num_visits_ = 0;
    is_away_ = true;
    at_edge_.clear();
  }
  if (value >= edge_ - same) {
    count_ += count;
    num_visits_ += is_away_;
    is_away_ = false;
    at_edge_.add(first, count);
    return;
  }
  is_away_ = value < next_ - same;
  if (is_away_) return;
  if (value > next_ + same) {
    next_ = value;
    next_count_ = 0;
  }
  next_count_ += count;
}

bool HistogramEdge::piles_up(Eigen::Index at_least) const {
  constexpr std::int64_t least_count = 10, least_visits = 3, ratio = 8;
  return count_ >= least_count && num_visits_ >= least_visits && (next_count_ > 0 || width_ > 0.0) &&
         count_ >= ratio * next_count_ && at_edge_.longest() >= at_least;
}

}  // namespace dsp
