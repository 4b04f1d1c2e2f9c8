#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "dsp/recording.hpp"

namespace dsp {

/// Samples with something in common, as ranges; those closer than `merge_gap` become one.
class SampleRanges {
 public:
  explicit SampleRanges(Eigen::Index merge_gap) : merge_gap_(merge_gap) {}
  void add(Eigen::Index first, Eigen::Index count);  ///< in rising order
  void clear() { *this = SampleRanges(merge_gap_); }
  [[nodiscard]] const std::vector<IndexRange>& list() const& { return list_; }
  void list() const&& = delete;
  [[nodiscard]] Eigen::Index longest() const { return longest_; }  ///< successive ones

 private:
  Eigen::Index merge_gap_, run_ = 0, longest_ = 0;
  std::vector<IndexRange> list_;
};

/// One side of a channel: where it reaches the end of its range, if that is known, and the edge of the histogram of its
/// values: how often it was at the largest value met (sign = 1) or the smallest (-1), and how often next to that.
class HistogramEdge {
 public:
  /// `limit`: in samples times sign; infinity: not known.
  HistogramEdge(double sign, double limit, Eigen::Index merge_gap)
      : sign_(sign), limit_(limit), at_limit_(merge_gap), at_edge_(merge_gap) {}
  /// How wide noise makes one value; 0: values are equal or not. Much wider than before: all begins anew.
  void set_width(double width);
  [[nodiscard]] double width() const { return width_; }
  /// What stays below, of this sign, need not be looked at.
  [[nodiscard]] double least() const { return std::min(next_, limit_); }
  /// `count` samples from `first` on, the outermost of which is `value`.
  void look(double value, Eigen::Index first, Eigen::Index count);
  /// A limit shows as a value met again and again, while those next to it are not. A smooth maximum, rounded, is met up
  /// to 2.4 times as often as the value next to it (parabola: 2 sqrt(1) against 2 (sqrt(2) - 1)), up to 5 times if it
  /// takes few samples; and what comes to rest at its maximum stays there as long as it likes, but comes by way of the
  /// next value. So: eight times as often, on three visits that come from farther. `at_least`: successive samples, at
  /// the least, in one place.
  [[nodiscard]] bool piles_up(Eigen::Index at_least) const;
  [[nodiscard]] std::int64_t count() const { return count_; }
  [[nodiscard]] double value() const { return sign_ * edge_; }
  [[nodiscard]] const SampleRanges& at_limit() const& { return at_limit_; }
  void at_limit() const&& = delete;
  [[nodiscard]] const SampleRanges& at_edge() const& { return at_edge_; }
  void at_edge() const&& = delete;

 private:
  static constexpr double none = -std::numeric_limits<double>::infinity();
  double sign_, limit_, width_ = 0.0;
  double edge_ = none, next_ = none;
  std::int64_t count_ = 0, next_count_ = 0, num_visits_ = 0;
  bool is_away_ = true;         ///< the latest sample was below both
  Eigen::Index looked_at_ = 0;  ///< up to here
  SampleRanges at_limit_, at_edge_;
};

}  // namespace dsp
