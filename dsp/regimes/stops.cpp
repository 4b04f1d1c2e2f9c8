#include "dsp/regimes/stops.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "dsp/regimes/halt_rows.hpp"
#include "dsp/regimes/harmonics.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// In samples; std of its length by noise; early: by how much it ends before `to` where it comes loose by degrees.
struct Stand {
  double from = 0.0, to = 0.0, std = 0.0, early = 0.0;
};

/// Of the low-pass that v is behind, in samples.
double wave(const RegimeSigns& signs) {
  return signs.sample_rate_hz / signs.speed_cutoff_hz;
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
  const Index end = std::min(signs.num_samples(), last + static_cast<Index>(signs.quarter_period()) + 1);
  Index behind = last;
  while (behind < end && std::abs(signs.velocity_m_per_s(behind)) < 4.0 * slow) ++behind;
  if (behind == end || behind == last) return 1.0;
  const double at_four_times = crossing(signs, behind, behind - 1, 4.0 * slow);
  return 1.0 / (std::clamp((at_four_times - at_twice) / (at_twice - at_slow), std::numbers::sqrt2, 2.0) - 1.0);
}

/// Of [first, last), where |v| is below twice `slow`, if it gets below that. What an end of the record cuts is passed
/// as it is on the other side.
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
    if (after > 0.0) found.early = after * (rises(signs, last, slow, found.to, found.to + after) - 1.0);
  }
  if (first == 0) before = after;
  if (last == signs.num_samples()) after = before;
  found.from += before, found.to -= after;
  found.std = std::max(std::sqrt(rounding), std::hypot(before, after) * signs.speed_noise_m_per_s / slow);
  return found;
}

/// The velocity has the same sign before and after; shorter than one period of the low-pass that is a touch of zero, or
/// a crossing for its half period, the shortest that passes.
bool touches(const RegimeSigns& signs, Index first, Index last, double stood) {
  const VectorXd& v = signs.velocity_m_per_s;
  return first > 0 && last < v.size() && (v(first - 1) > 0.0) == (v(last) > 0.0) && stood < wave(signs);
}

/// Where the motion may halt, samples [first, last), and the logarithm of how much more probable a halt makes its
/// signs.
struct Passage {
  Index first = 0, last = 0;
  double log_ratio = 0.0;
};

/// Of two looks at one, the clearer; if both show a halt it lasts as long as either shows.
Passage either(const Passage& a, const Passage& b) {
  const Passage& clearer = a.log_ratio >= b.log_ratio ? a : b;
  if (std::min(a.log_ratio, b.log_ratio) <= 0.0) return clearer;
  return {std::min(a.first, b.first), std::max(a.last, b.last), clearer.log_ratio};
}

/// [first, last) below twice the threshold: where it stands in it, samples [from, to), for how long, the standard
/// deviation of that by noise, and how long it stands if it comes loose at once.
struct SlowRun {
  Index first = 0, last = 0, from = 0, to = 0;
  double stood = 0.0, std = 0.0, at_once = 0.0;
};

std::optional<SlowRun> slow_run(const RegimeSigns& signs, const SegmentOptions& options, Index first, Index last) {
  const auto found = stand(signs, first, last, options.stick_speed_m_per_s);
  if (!found || touches(signs, first, last, found->to - found->from)) return {};
  // The tangent of a sharp bend behind the low-pass reaches zero by so much later than the bend.
  constexpr double late_waves = 1.0 / (std::numbers::pi * std::numbers::pi);
  const double late = late_waves * wave(signs);
  const double to = std::max(found->from, found->to - found->early);
  const Index n = signs.num_samples();
  const Index from_sample = first == 0 ? 0 : std::clamp<Index>(static_cast<Index>(std::ceil(found->from - late)), 0, n);
  return SlowRun{first,
                 last,
                 from_sample,
                 last == n ? n : std::clamp<Index>(static_cast<Index>(std::floor(to)) + 1, from_sample, n),
                 found->to - found->early - found->from,
                 found->std,
                 found->to - found->from};
}

/// What stands for less than nothing shows by how much times err, of whatever shape the motion is; but for what an end
/// of the record cuts.
double time_error(const std::vector<SlowRun>& runs, Index num_samples) {
  double square = 0.0, count = 0.0;
  for (const SlowRun& run : runs)
    if (run.at_once < 0.0 && run.first > 0 && run.last < num_samples) square += run.at_once * run.at_once, count += 1.0;
  return count > 0.0 ? std::sqrt(square / count) : 0.0;
}

/// Nothing drives it: the force is always where it was a wave before. Slower changes it may have by its own filters, as
/// where a motion is integrated.
bool force_rests(const RegimeSigns& signs, const Passage& one) {
  if (signs.force.size() == 0) return false;
  const Index back = static_cast<Index>(wave(signs)) + 1;
  for (Index i = std::max(one.first, back); i < one.last; ++i)
    if (std::abs(signs.force(i) - signs.force(i - back)) > sensors_agree * signs.force_span) return false;
  return true;
}

/// From sample `at` on, in steps of 1 or -1, behind the last of the swings that follow on one another up to `end`: to
/// one side for a quarter of a period and more, faster than noise and than what is as good as at rest beside it. `at`
/// may lie within the swing before.
Index behind_swings(const RegimeSigns& signs, Index at, Index end, Index step) {
  const VectorXd& v = signs.velocity_m_per_s;
  const auto lasts = [&](Index from, Index to) {
    return static_cast<double>(std::abs(to - from)) >= signs.quarter_period();
  };
  Index behind = at;
  for (Index first = at, next = at; first != end; first = next) {
    double largest = 0.0;
    for (; next != end && (v(next) > 0.0) == (v(first) > 0.0); next += step)
      largest = std::max(largest, std::abs(v(next)));
    Index begin = first, rest = next;
    while (begin != next && std::abs(v(begin)) <= sensors_agree * largest) begin += step;
    while (rest != begin && std::abs(v(rest - step)) <= sensors_agree * largest) rest -= step;
    const bool swings = lasts(begin, rest) && largest > noise_stds * signs.speed_noise_m_per_s,
               rests_behind = lasts(rest, next);
    if (lasts(first, begin) || (!swings && first != at)) break;
    if (swings) behind = rests_behind ? rest : next;
    if (rests_behind) break;
  }
  return behind;
}

/// What nothing drives and goes on swinging has not stopped, however small it has become, nor has what swings up from
/// next to nothing: of a rest what such swings leave of it, if that lasts for a quarter of a period.
std::optional<Passage> without_swings(const RegimeSigns& signs, Passage one) {
  const auto is_short = [&] { return static_cast<double>(one.last - one.first) < signs.quarter_period(); };
  const bool driven = !signs.base_rests || (signs.force.size() > 0 && !force_rests(signs, one));
  if (signs.speed_is_given || driven || is_short()) return one;
  one.first = behind_swings(signs, one.first, one.last, 1);
  one.last = behind_swings(signs, one.last - 1, one.first - 1, -1) + 1;
  if (is_short()) return {};
  return one;
}

/// By the speed and by the acceleration at the reversal in it, whichever shows a halt more clearly.
std::vector<Passage> passages(const RegimeSigns& signs, const SegmentOptions& options) {
  std::vector<Passage> all;
  auto reversal = signs.reversals.begin();
  const auto by_acceleration = [&](const Reversal& one) {
    const bool counts = one.halt_s > 0.0 && one.halt_s >= options.stick_duration_s;
    return Passage{one.at, one.at + signs.samples_in(one.halt_s),
                   counts ? one.log_ratio : std::min(0.0, one.log_ratio)};
  };
  const auto up_to = [&](Index end) {
    for (; reversal != signs.reversals.end() && reversal->at < end; ++reversal)
      all.push_back(by_acceleration(*reversal));
  };
  std::vector<SlowRun> runs;
  const Index n = signs.num_samples();
  for (Index i = 0; i < n; ++i) {
    const Index first = i;
    while (i < n && std::abs(signs.velocity_m_per_s(i)) < 2.0 * options.stick_speed_m_per_s) ++i;
    if (i == first) continue;
    if (const auto run = slow_run(signs, options, first, i)) runs.push_back(*run);
  }
  const double error = time_error(runs, n),
               shortest_s = std::max(options.stick_duration_s, signs.is_coarse ? signs.period_s : 0.0),
               shortest = std::max(1.0, shortest_s * signs.sample_rate_hz);
  for (const SlowRun& run : runs) {
    const double log_ratio = log_ratio_of_halt(run.stood < shortest ? 0.0 : run.stood, std::max(run.std, error),
                                               2.0 * signs.quarter_period());
    const auto rest = without_swings(signs, {run.from, run.to, log_ratio});
    if (!rest) continue;
    Passage clearest = *rest;
    up_to(rest->first > run.from ? rest->first : run.first);
    for (; reversal != signs.reversals.end() && reversal->at <= run.last; ++reversal)
      clearest = either(clearest, by_acceleration(*reversal));
    all.push_back(clearest);
  }
  up_to(n);
  return all;
}

VectorXd probabilities(const std::vector<Passage>& all) {
  VectorXd log_ratios(static_cast<Index>(all.size()));
  for (Index k = 0; k < log_ratios.size(); ++k) log_ratios(k) = all[static_cast<std::size_t>(k)].log_ratio;
  return halt_probabilities(log_ratios);
}

}  // namespace

double stop_std_s(const RegimeSigns& signs) {
  return std::sqrt(rounding) / signs.speed_cutoff_hz;
}

std::vector<bool> stick_mask(const RegimeSigns& signs, const SegmentOptions& options) {
  std::vector<bool> stuck(static_cast<std::size_t>(signs.num_samples()), false);
  std::vector<Passage> all = passages(signs, options);
  const VectorXd halts = probabilities(all);
  std::vector<Passage> driven = all;
  std::erase_if(driven, [&](const Passage& one) { return force_rests(signs, one); });
  if (driven.size() < all.size() && (probabilities(driven).array() <= 0.5).all()) return stuck;
  for (Index k = 0; k < halts.size(); ++k) {
    const Passage& one = all[static_cast<std::size_t>(k)];
    if (halts(k) > 0.5) std::fill(stuck.begin() + one.first, stuck.begin() + one.last, true);
  }
  return stuck;
}

}  // namespace dsp
