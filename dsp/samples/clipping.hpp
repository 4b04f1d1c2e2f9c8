#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

namespace dsp {

/// Indices with something in common, as index ranges; those closer than `merge_gap` become one.
class IndexRanges {
 public:
  struct CountedRange {
    Eigen::Index first = 0, last = 0;   ///< [first, last)
    Eigen::Index count = 0;             ///< indices added
    Eigen::Index run = 0, longest = 0;  ///< successive indices added: at the end, at most
  };
  explicit IndexRanges(Eigen::Index merge_gap) : merge_gap_(merge_gap) {}
  void add(Eigen::Index index);  ///< in rising order
  void clear() { list_.clear(); }
  [[nodiscard]] const std::vector<CountedRange>& list() const& { return list_; }
  void list() const&& = delete;

 private:
  Eigen::Index merge_gap_;
  std::vector<CountedRange> list_;
};

/// One side of a channel: where it reaches a known limit, and where it equals the largest value met (sign = 1) or the
/// smallest (sign = -1).
class ExtremeValue {
 public:
  /// `limit`: in samples times sign; infinity: none known.
  ExtremeValue(double sign, double limit, Eigen::Index merge_gap)
      : sign_(sign), limit_(limit), at_limit_(merge_gap), at_extreme_(merge_gap) {}
  /// Cells whose largest sample, of this sign, is less do not matter here. Few do: what reaches the second largest
  /// value met.
  [[nodiscard]] double least() const { return std::min(next_, limit_); }
  template <class Samples>
  void scan(const Samples& samples, Eigen::Index first) {
    away_ = away_ || first != scanned_;
    for (Eigen::Index i = 0; i < samples.size(); ++i) look(sign_ * samples(i), first + i);
    scanned_ = first + samples.size();
  }
  /// A limit shows as a value met again and again, while those next to it are not. A smooth maximum, rounded, is met up
  /// to 2.4 times as often as the value next to it (parabola: 2 sqrt(1) against 2 (sqrt(2) - 1)), up to 5 times if it
  /// takes few samples; and what comes to rest at its maximum stays there as long as it likes, but comes by way of the
  /// next value. So: eight times as often, on three visits that come from farther. `at_least`: successive samples, at
  /// the least, in one place.
  [[nodiscard]] bool piled_up(Eigen::Index at_least) const;
  [[nodiscard]] std::int64_t count() const { return count_; }
  [[nodiscard]] double value() const { return sign_ * extreme_; }
  [[nodiscard]] const IndexRanges& at_limit() const& { return at_limit_; }
  void at_limit() const&& = delete;
  [[nodiscard]] const IndexRanges& at_extreme() const& { return at_extreme_; }
  void at_extreme() const&& = delete;

 private:
  void look(double value, Eigen::Index frame);

  double sign_, limit_;
  double extreme_ = -std::numeric_limits<double>::infinity(), next_ = extreme_;  ///< largest and second largest
  std::int64_t count_ = 0, next_count_ = 0, num_visits_ = 0;
  bool away_ = true;          ///< the latest sample was below both
  Eigen::Index scanned_ = 0;  ///< up to here
  IndexRanges at_limit_, at_extreme_;
};

/// How often a channel was at which level, in bins that widen as its range does.
class LevelHistogram {
 public:
  void add(double level, bool still);
  /// A limit with noise on top: at the upper end (sign = 1) or the lower one, what lies within 1/512 of the range or so
  /// stands still and is met four times as often as what comes next. Infinity times sign: none.
  [[nodiscard]] double plateau(double sign) const;
  [[nodiscard]] double resolution() const { return plateau_bins * width_; }

 private:
  static constexpr int num_bins = 4096, plateau_bins = 4;
  struct Bin {
    std::int64_t all = 0, still = 0;
  };
  void widen(bool downwards);

  double origin_ = 0.0, width_ = 0.0, per_level_ = 0.0;  ///< of bins; width 0: one level so far, in the first bin
  std::vector<Bin> bins_ = std::vector<Bin>(num_bins);
};

}  // namespace dsp
