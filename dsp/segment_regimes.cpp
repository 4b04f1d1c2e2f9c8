#include "dsp/segment_regimes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "dsp/regimes/branches.hpp"
#include "dsp/regimes/regime_thresholds.hpp"
#include "dsp/regimes/stops.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Labels = std::vector<Regime>;

/// The cycle of the drive at a sample; the dominant period where nothing drives the motion.
Index cycle_at(Index sample, const std::vector<HalfCycle>& halves, const RegimeSigns& signs) {
  const auto behind = std::upper_bound(halves.begin(), halves.end(), sample,
                                       [](Index at, const HalfCycle& half) { return at < half.middle; });
  if (behind == halves.begin() || behind == halves.end() || !std::isfinite(behind->phase_variance))
    return signs.samples_in(signs.period_s);
  return behind->last - behind->first;
}

/// What moves for less than a cycle between two stops, nothing of it excluded, is part of them.
void join_stops(std::vector<bool>& stuck, const std::vector<HalfCycle>& halves, const RegimeSigns& signs) {
  const Index n = signs.num_samples();
  const auto is_stuck = [&](Index i) { return stuck[static_cast<std::size_t>(i)]; };
  const auto join = [&](Index first, Index last) { std::fill(stuck.begin() + first, stuck.begin() + last, true); };
  Index moving_since = -1, row_end = -1;  // the last stop ended here; so did the last row of them
  for (Index i = 0; i < n; ++i) {
    if (signs.excluded[static_cast<std::size_t>(i)] != 0) moving_since = -1;
    if (!is_stuck(i)) continue;
    if (moving_since >= 0 && i > moving_since && i - moving_since < cycle_at(moving_since, halves, signs)) {
      join(moving_since, i);
      row_end = i;
    }
    moving_since = i + 1;
  }
  // A row that the record cuts goes on to its last reversal, too near the end to be looked at.
  if (row_end < 0) return;
  while (row_end < n && is_stuck(row_end)) ++row_end;
  const auto sign = [&](Index i) { return signs.velocity_m_per_s(i) >= 0.0; };
  Index reversal = n - 1;
  while (reversal > row_end && sign(reversal) == sign(reversal - 1)) --reversal;
  const Index unseen = n - sign_change_margin(signs.samples_in(signs.period_s));
  if (reversal < std::max(row_end + 1, unseen) || reversal - row_end >= cycle_at(row_end - 1, halves, signs)) return;
  if (std::all_of(signs.excluded.begin() + row_end, signs.excluded.end(), [](unsigned char one) { return one == 0; }))
    join(row_end, reversal);
}

std::vector<Segment> runs(const Labels& labels) {
  std::vector<Segment> segments;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto index = static_cast<Index>(i);
    if (segments.empty() || segments.back().regime != labels[i]) segments.push_back({labels[i], index, index, {}});
    segments.back().last = index + 1;
  }
  return segments;
}

/// Low and high over the whole record, whatever else is there.
Labels branch_labels(const Branches& branches, Index num_samples) {
  Labels labels;
  for (std::size_t i = 0; i < branches.intervals.size(); ++i) {
    const Index end = i + 1 < branches.intervals.size() ? branches.intervals[i + 1].first : num_samples;
    labels.resize(static_cast<std::size_t>(end), branches.intervals[i].upper ? Regime::high : Regime::low);
  }
  return labels;
}

/// Probabilities, and standard deviations of ends that lie where a branch begins, or a stop begins or ends.
void qualify(std::vector<Segment>& segments, const Branches& branches, double stop_std_s) {
  const auto& intervals = branches.intervals;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    Segment& segment = segments[i];
    const bool excluded = segment.regime == Regime::excluded || (i > 0 && segments[i - 1].regime == Regime::excluded);
    if (i > 0 && !excluded && (segment.regime == Regime::stick || segments[i - 1].regime == Regime::stick))
      segment.first_std_s = segments[i - 1].last_std_s = stop_std_s;
    if (segment.regime != Regime::low && segment.regime != Regime::high) continue;
    const auto behind = std::upper_bound(intervals.begin(), intervals.end(), segment.first,
                                         [](Index first, const BranchInterval& one) { return first < one.first; });
    const BranchInterval& in = *(behind - 1);
    segment.probability = in.probability;
    if (i > 0 && !excluded && in.first == segment.first)
      segment.first_std_s = segments[i - 1].last_std_s = in.first_std_s;
  }
}

}  // namespace

Segmentation segment_regimes(const Motion& motion, const SegmentOptions& options) {
  if (options.stick_speed_m_per_s < 0.0 || options.stick_duration_s < 0.0 || options.high_amplitude_m < 0.0)
    throw std::invalid_argument("segment_regimes: thresholds must not be negative");
  Segmentation result;
  result.options = options;
  if (motion.at("x").size() == 0) return result;
  RegimeSigns signs = regime_signs(motion);
  choose_stick(signs, result);
  // A speed that is given is the only sign of a stop, and where noise hides them there is none.
  signs.speed_is_given = options.stick_speed_m_per_s > 0.0;
  if (signs.speed_is_given || result.options.stick_speed_m_per_s == 0.0) signs.reversals.clear();
  std::vector<bool> stuck = stick_mask(signs, result.options);
  const std::vector<HalfCycle> halves = half_cycles(motion, signs.period_s);
  join_stops(stuck, halves, signs);
  const double rate_hz = signs.sample_rate_hz;
  const Branches branches =
      options.high_amplitude_m > 0.0
          ? branches_by_amplitude(own_half_cycles(motion, signs.period_s), options.high_amplitude_m, rate_hz)
          : find_branches(halves, stuck, signs.excluded, rate_hz);
  result.remarks.push_back(branches.remark);
  Labels labels = branch_labels(branches, signs.num_samples());
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (signs.excluded[i] != 0)
      labels[i] = Regime::excluded;
    else if (stuck[i])
      labels[i] = Regime::stick;
  result.segments = runs(labels);
  qualify(result.segments, branches, stop_std_s(signs));
  result.mount = signs.mount;
  return result;
}

std::vector<Regime> regimes_at(const Segmentation& segmentation, const Motion& intermediate, const Motion& signals) {
  std::vector<Regime> regimes(static_cast<std::size_t>(signals.num_samples()), Regime::excluded);
  const double ratio = intermediate.sample_rate_hz / signals.sample_rate_hz;
  auto segment = segmentation.segments.begin();
  for (std::size_t i = 0; i < regimes.size(); ++i) {
    const auto sample = static_cast<Index>(std::llround(static_cast<double>(i) * ratio));
    while (segment != segmentation.segments.end() && segment->last <= sample) ++segment;
    if (segment != segmentation.segments.end()) regimes[i] = segment->regime;
  }
  return regimes;
}

}  // namespace dsp
