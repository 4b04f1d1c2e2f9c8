#include "dsp/regimes/stops.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// In samples; std of its length by noise; early: by how much it ends before `to` where it comes loose by degrees.
struct Stand {
  double from = 0.0, to = 0.0, std = 0.0, early = 0.0;
};

double quarter_period(const RegimeSigns& signs) {
  return signs.period_s / 4.0 * signs.sample_rate_hz;
}

/// Where |v| passes `level` between a sample below it and the one beside it that is above.
double crossing(const RegimeSigns& signs, Index above, Index below, double level) {
  const double high = std::abs(signs.velocity_m_per_s(above)), low = std::abs(signs.velocity_m_per_s(below));
  return static_cast<double>(below) + (level - low) / (high - low) * static_cast<double>(above - below);
}

/// How many times as long as from one to two times `slow` it took from zero to one: once where it comes loose at once
/// and the speed rises straight, 1 + sqrt(2) times where the pull exceeds friction by degrees and the speed rises with
/// the square of time; between the two by Aitken's extrapolation. It is at twice `slow` before `last`. Once where it is
/// not at four times that within a quarter of a period.
double rises(const RegimeSigns& signs, Index last, double slow, double at_slow, double at_twice) {
  const Index end = std::min(signs.num_samples(), last + static_cast<Index>(quarter_period(signs)) + 1);
  Index behind = last;
  while (behind < end && std::abs(signs.velocity_m_per_s(behind)) < 4.0 * slow) ++behind;
  if (behind == end || behind == last) return 1.0;
  const double at_four_times = crossing(signs, behind, behind - 1, 4.0 * slow);
  return 1.0 / (std::clamp((at_four_times - at_twice) / (at_twice - at_slow), std::numbers::sqrt2, 2.0) - 1.0);
}

/// Of [first, last), where |v| is below twice `slow`, if it gets below that. What lasts for a quarter of a period is no
/// passage, and what an end of the record cuts is passed as it is on the other side.
std::optional<Stand> stand(const RegimeSigns& signs, Index first, Index last, double slow) {
  const auto speed = [&](Index i) { return std::abs(signs.velocity_m_per_s(i)); };
  Index begin = first, end = last - 1;
  while (begin < last && speed(begin) >= slow) ++begin;
  while (end >= first && speed(end) >= slow) --end;
  if (begin == last) return {};
  Stand found{static_cast<double>(begin), static_cast<double>(end)};
  double before = 0.0, after = 0.0;
  if (first > 0) {
    found.from = crossing(signs, begin - 1, begin, slow);
    before = found.from - crossing(signs, first - 1, first, 2.0 * slow);
  }
  if (last < signs.num_samples()) {
    found.to = crossing(signs, end + 1, end, slow);
    after = crossing(signs, last, last - 1, 2.0 * slow) - found.to;
    if (after > 0.0 && after < quarter_period(signs))
      found.early = after * (rises(signs, last, slow, found.to, found.to + after) - 1.0);
  }
  const double reach = quarter_period(signs);
  if (before >= reach) before = 0.0;
  if (after >= reach) after = 0.0;
  if (first == 0) before = after;
  if (last == signs.num_samples()) after = before;
  found.from += before, found.to -= after;
  found.std = std::hypot(before, after) * signs.speed_noise_m_per_s / slow;
  return found;
}

/// It comes from where it goes to: for less than half a wave of the low-pass it may as well have touched zero.
bool touches(const RegimeSigns& signs, Index first, Index last, double stood) {
  const VectorXd& v = signs.velocity_m_per_s;
  return first > 0 && last < v.size() && (v(first - 1) > 0.0) == (v(last) > 0.0) &&
         2.0 * signs.speed_cutoff_hz * stood < signs.sample_rate_hz;
}

bool is_blurred(const RegimeSigns& signs) {
  return signs.speed_cutoff_hz < 0.5 * signs.sample_rate_hz;
}

}  // namespace

double stop_std_s(const RegimeSigns& signs) {
  return is_blurred(signs) ? 0.25 / signs.speed_cutoff_hz : 0.0;
}

std::vector<bool> stick_mask(const RegimeSigns& signs, const SegmentOptions& options) {
  const Index n = signs.num_samples();
  std::vector<bool> stuck(static_cast<std::size_t>(n), false);
  const double shortest = options.stick_duration_s * signs.sample_rate_hz, slow = options.stick_speed_m_per_s;
  constexpr double stds = 3.0, late_periods = 0.15;
  const double late = is_blurred(signs) ? late_periods / signs.speed_cutoff_hz * signs.sample_rate_hz : 0.0;
  const auto stop = [&](double from, double to) {
    const auto first = static_cast<Index>(std::ceil(from)), last = static_cast<Index>(std::floor(to)) + 1;
    std::fill(stuck.begin() + std::max<Index>(0, first), stuck.begin() + std::min(n, last), true);
  };
  for (Index i = 0; i < n; ++i) {
    const Index first = i;
    while (i < n && std::abs(signs.velocity_m_per_s(i)) < 2.0 * slow) ++i;
    if (i == first) continue;
    const auto found = stand(signs, first, i, slow);
    if (!found) continue;
    const double stood = found->to - found->from;
    if (stood >= std::max(shortest, stds * found->std) && !touches(signs, first, i, stood))
      stop(found->from - late, std::max(found->from, found->to - found->early));
  }
  for (const Reversal& reversal : signs.reversals)
    if (options.stick_halt_s > 0.0 && reversal.halt_s >= options.stick_halt_s)
      stop(static_cast<double>(reversal.at), static_cast<double>(reversal.at + signs.samples_in(reversal.halt_s) - 1));
  return stuck;
}

}  // namespace dsp
