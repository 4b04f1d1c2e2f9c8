#include "dsp/segment_regimes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "dsp/regimes/regime_thresholds.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Labels = std::vector<Regime>;

Labels label(const RegimeSigns& signs, const SegmentOptions& options, const std::vector<bool>& stuck) {
  Labels labels(stuck.size(), Regime::low);
  bool high = false;
  for (std::size_t i = 0; i < stuck.size(); ++i) {
    const auto index = static_cast<Index>(i);
    const double level = signs.envelope_m(index);
    if (level > options.high_enter_m)
      high = true;
    else if (level < options.high_leave_m || against_base(signs, index))
      high = false;
    labels[i] = stuck[i] ? Regime::stick : high ? Regime::high : Regime::low;
    if (signs.excluded[i] != 0) labels[i] = Regime::excluded;
  }
  return labels;
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

// Short runs join their left neighbour (or become stick between two sticks); a stop, and what was excluded, stays so
// however short. A run that an exclusion or an end of the record cuts may have been longer, and stays.
std::vector<Segment> without_short_runs(std::vector<Segment> segments, Index shortest) {
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < segments.size() && !changed; ++i) {
      Segment& run = segments[i];
      if (run.regime == Regime::excluded || run.regime == Regime::stick || run.last - run.first >= shortest) continue;
      const bool whole = i > 0 && segments[i - 1].regime != Regime::excluded && i + 1 < segments.size() &&
                         segments[i + 1].regime != Regime::excluded;
      if (!whole) continue;
      run.regime = segments[i - 1].regime;
      changed = true;
    }
    if (!changed) break;
    Labels labels(static_cast<std::size_t>(segments.back().last));
    for (const Segment& run : segments) std::fill(labels.begin() + run.first, labels.begin() + run.last, run.regime);
    segments = runs(labels);
  }
  return segments;
}

}  // namespace

Segmentation segment_regimes(const Motion& motion, const SegmentOptions& options) {
  if (options.stick_speed_m_per_s < 0.0 || options.stick_duration_s < 0.0 || options.stick_halt_s < 0.0 ||
      options.high_enter_m < 0.0 || options.high_leave_m < 0.0 || options.envelope_window_s <= 0.0 ||
      options.baseline_window_s <= 0.0)
    throw std::invalid_argument("segment_regimes: thresholds must not be negative and windows must be positive");
  if (options.high_enter_m > 0.0 && options.high_leave_m > options.high_enter_m)
    throw std::invalid_argument("segment_regimes: high_leave_m lies above high_enter_m");
  Segmentation result;
  result.options = options;
  if (motion.at("x").size() == 0) return result;
  RegimeSigns signs = regime_signs(motion, options);
  choose_stick(signs, result);
  const std::vector<bool> stuck = stick_mask(signs, result.options);
  choose_high(signs, stuck, result);
  result.segments =
      without_short_runs(runs(label(signs, result.options, stuck)), signs.samples_in(options.min_duration_s));
  result.envelope_m = std::move(signs.envelope_m);
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
