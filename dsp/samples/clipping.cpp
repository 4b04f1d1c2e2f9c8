#include "dsp/samples/clipping.hpp"

#include <algorithm>
#include <cmath>

namespace dsp {

void IndexRanges::add(Eigen::Index index) {
  if (list_.empty() || index - list_.back().last > merge_gap_) list_.push_back({index, index, 0, 0, 0});
  auto& range = list_.back();
  range.run = index == range.last ? range.run + 1 : 1;
  range.longest = std::max(range.longest, range.run);
  range.last = index + 1;
  ++range.count;
}

void ExtremeValue::look(double value, Eigen::Index frame) {
  if (value >= limit_) at_limit_.add(frame);
  for (const double met : {extreme_, next_})
    if (std::abs(value - met) <= 1e-9 * std::abs(value)) value = met;  // but for rounding
  if (value < next_) {
    away_ = true;
    return;
  }
  if (value > extreme_) {
    next_ = extreme_;
    next_count_ = count_;
    extreme_ = value;
    count_ = num_visits_ = 0;
    away_ = true;
    at_extreme_.clear();
  }
  if (value == extreme_) {
    ++count_;
    num_visits_ += away_;
    at_extreme_.add(frame);
  } else if (value > next_) {
    next_ = value;
    next_count_ = 1;
  } else {
    ++next_count_;
  }
  away_ = false;
}

bool ExtremeValue::piled_up(Eigen::Index at_least) const {
  constexpr std::int64_t least_count = 10, least_visits = 3, ratio = 8;
  return count_ >= least_count && num_visits_ >= least_visits && next_count_ > 0 && count_ >= ratio * next_count_ &&
         std::any_of(at_extreme_.list().begin(), at_extreme_.list().end(),
                     [&](const auto& range) { return range.longest >= at_least; });
}

void LevelHistogram::add(double level, bool still) {
  if (width_ == 0.0) {
    if (bins_[0].all == 0) origin_ = level;
    if (level != origin_) {  // the first level goes to the middle, the second within an eighth of the bins
      width_ = std::max(std::abs(level - origin_) * 8 / num_bins, std::abs(origin_) * 1e-15);
      std::swap(bins_[0], bins_[num_bins / 2]);
      origin_ -= width_ * num_bins / 2;
      per_level_ = 1.0 / width_;
    }
  }
  double position = (level - origin_) * per_level_;
  for (; !(position >= 0.0 && position < num_bins); position = (level - origin_) * per_level_) widen(position < 0.0);
  auto& bin = bins_[static_cast<std::size_t>(position)];
  ++bin.all;
  bin.still += still;
}

void LevelHistogram::widen(bool downwards) {
  std::vector<Bin> wider(num_bins);
  const std::size_t shift = downwards ? num_bins / 2 : 0;
  for (std::size_t i = 0; i < num_bins; ++i) {
    wider[shift + i / 2].all += bins_[i].all;
    wider[shift + i / 2].still += bins_[i].still;
  }
  if (downwards) origin_ -= width_ * num_bins;
  width_ *= 2;
  per_level_ /= 2;
  bins_ = std::move(wider);
}

double LevelHistogram::plateau(double sign) const {
  const auto at = [&](int i) { return bins_[static_cast<std::size_t>(sign > 0 ? num_bins - 1 - i : i)]; };
  // From the end inwards: bins from the first that is not empty.
  const auto group = [&](int& begin) {
    while (begin < num_bins && at(begin).all == 0) ++begin;
    Bin sum;
    for (int i = begin; i < std::min(begin + plateau_bins, num_bins); ++i) {
      sum.all += at(i).all;
      sum.still += at(i).still;
    }
    return sum;
  };
  constexpr std::int64_t least_count = 16, ratio = 4;
  double found = std::numeric_limits<double>::infinity() * sign;
  if (width_ == 0.0) return found;
  int begin = 0;
  for (Bin top = group(begin); begin < num_bins;) {
    const int end = begin + plateau_bins;
    begin = end;
    const Bin next = group(begin);
    const std::int64_t added = top.all - next.all;  // what passes through is as often next to it
    if (top.all < least_count || 10 * top.still < 9 * added || top.all < ratio * next.all) break;
    found = origin_ + width_ * (sign > 0 ? num_bins - end : end);
    top = next;  // a dropout may be beyond the limit
  }
  return found;
}

}  // namespace dsp
