#include "dsp/regimes/regime_thresholds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "dsp/order_statistics.hpp"

namespace dsp {
namespace {

using Eigen::Index;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double clear_phase = 0.3;                // |cosine| from which x is in phase with the base or against it
constexpr double leave_fraction = 0.8;             // of the smallest amplitude on the upper branch
constexpr double leave_fraction_by_growth = 0.85;  // where growth is what shows it
constexpr double apart = 1.2;                      // amplitudes of two branches differ by this factor at least

/// Velocity amplitudes of cycles. A cycle moves if it reaches a tenth of the record's.
struct CycleAmplitudes {
  double small = 0.0;  ///< that 97 of 100 cycles in motion exceed
  double shown = 0.0;  ///< that noise is held against: the same; where most cycles rest, the median of the others
};

CycleAmplitudes velocity_amplitudes(const RegimeSigns& signs) {
  const Index period = signs.samples_in(signs.period_s);
  std::vector<double> peaks;
  for (Index first = 0; first + period <= signs.num_samples(); first += period)
    peaks.push_back(signs.speed_m_per_s.segment(first, period).maxCoeff());
  if (peaks.empty()) return {signs.speed_m_per_s.maxCoeff(), signs.speed_m_per_s.maxCoeff()};
  std::sort(peaks.begin(), peaks.end());
  const auto above = [&](double bar) { return std::lower_bound(peaks.begin(), peaks.end(), bar); };
  const auto part = [&](auto from, std::ptrdiff_t percent) { return from[(peaks.end() - from) * percent / 100]; };
  constexpr double clear_of_noise = 5.0;
  const auto clear = above(clear_of_noise * signs.speed_noise_m_per_s);
  if (clear != peaks.end() && 2 * (peaks.end() - clear) < peaks.end() - peaks.begin())
    return {part(above(0.1 * part(clear, 90)), 3), part(clear, 50)};
  const double small = part(above(0.1 * part(peaks.begin(), 90)), 3);
  return {small, small};
}

struct Jump {
  Index at = 0;
  double before_m = 0.0, after_m = 0.0;
};

void set_high(double enter_m, double leave_m, std::string remark, Segmentation& result) {
  result.options.high_enter_m = enter_m;
  if (result.options.high_leave_m == 0.0) result.options.high_leave_m = std::min(leave_m, enter_m);
  if (std::isfinite(enter_m))
    remark += fmt::format(": high begins above {:.3g} m and ends below {:.3g} m", enter_m, result.options.high_leave_m);
  result.remarks.push_back(std::move(remark));
}

// ---- With a base: the branch is seen in the phase.

enum class Branch : signed char { none = 0, lower = -1, upper = 1 };

// Of each sample, with hysteresis; none in sticks and where the base is still. What is excluded has a branch, too:
// faulty samples are filled, and clipping leaves out just what lies behind a jump.
std::vector<Branch> branches(const RegimeSigns& signs, const std::vector<bool>& stuck) {
  std::vector<Branch> result(stuck.size(), Branch::none);
  Branch now = Branch::none;
  for (std::size_t i = 0; i < stuck.size(); ++i) {
    const double phase = signs.phase(static_cast<Index>(i));
    if (phase > clear_phase) now = Branch::upper;
    if (phase < -clear_phase) now = Branch::lower;
    if (phase == 0.0 || stuck[i]) now = Branch::none;
    result[i] = now;
  }
  return result;
}

// What the envelope has settled to where a branch begins (direction 1) or ends (-1) at `edge`: its mean over the first
// so many periods, six and more from there, that it keeps within a fraction of itself.
std::optional<double> settled_from(Index edge, int direction, double periods, double fraction, const RegimeSigns& signs,
                                   const std::vector<Branch>& all) {
  const Index window = signs.samples_in(periods * signs.period_s), step = signs.samples_in(signs.period_s);
  const Branch branch = all[static_cast<std::size_t>(direction > 0 ? edge : edge - 1)];
  for (Index away = 6 * step; away < 100 * step; away += step) {
    const Index first = direction > 0 ? edge + away : edge - away - window;
    if (first < 0 || first + window > signs.num_samples()) return std::nullopt;
    for (Index i = first; i < first + window; ++i)
      if (all[static_cast<std::size_t>(i)] != branch) return std::nullopt;
    const auto envelope = signs.envelope_m.segment(first, window);
    if (const double mean = envelope.mean(); envelope.maxCoeff() - envelope.minCoeff() < fraction * mean) return mean;
  }
  return std::nullopt;
}

// A slow jump lingers for some ten periods where the lower branch ends: long rest distinguishes that from a dwell.
// Behind a jump it swings; as soon as that is over counts, the next dwell has another amplitude.
std::optional<double> settled_from(Index edge, int direction, const RegimeSigns& signs,
                                   const std::vector<Branch>& all) {
  const auto strictly = direction < 0 ? settled_from(edge, direction, 18.0, 0.025, signs, all)
                                      : settled_from(edge, direction, 6.0, 0.02, signs, all);
  return strictly ? strictly : settled_from(edge, direction, 6.0, 0.05, signs, all);
}

void choose_by_phase(const RegimeSigns& signs, const std::vector<bool>& stuck, Segmentation& result) {
  const std::vector<Branch> all = branches(signs, stuck);
  const auto branch = [&](Index i) { return all[static_cast<std::size_t>(i)]; };
  const Index n = signs.num_samples(), settle = signs.samples_in(10.0 * signs.period_s);
  // What is settled on a branch: ten periods away from where the branch begins and ends.
  double largest_low = 0.0, smallest_high = infinity;
  std::vector<double> high, high_excluded;
  for (Index first = 0; first < n;) {
    Index last = first;
    while (last < n && branch(last) == branch(first)) ++last;
    for (Index i = first + settle; i < last - settle; ++i) {
      const bool is_excluded = signs.excluded[static_cast<std::size_t>(i)] != 0;
      if (branch(first) == Branch::lower && !is_excluded) largest_low = std::max(largest_low, signs.envelope_m(i));
      if (branch(first) == Branch::upper) (is_excluded ? high_excluded : high).push_back(signs.envelope_m(i));
    }
    first = last;
  }
  if (high.empty()) high = std::move(high_excluded);  // all of it clipped: better than to call it low
  if (!high.empty()) smallest_high = *std::min_element(high.begin(), high.end());
  std::vector<Jump> jumps;
  for (Index i = 1; i < n; ++i) {
    if (branch(i - 1) != Branch::lower || branch(i) != Branch::upper) continue;
    const auto before = settled_from(i, -1, signs, all), after = settled_from(i, +1, signs, all);
    if (before && after) jumps.push_back({i, *before, *after});
  }
  if (high.empty()) return set_high(infinity, infinity, "x never moves in phase with the base: one regime", result);
  double after = 0.0;
  if (jumps.empty()) {
    after = median(std::move(high));
  } else {  // a slow jump grows for longer than ten periods: what lies right before it is not settled
    largest_low = 0.0;
    for (const Jump& jump : jumps) {
      largest_low = std::max(largest_low, jump.before_m);
      after += std::log(jump.after_m) / static_cast<double>(jumps.size());
    }
    after = std::exp(after);
  }
  const double leave = leave_fraction * smallest_high;
  if (largest_low == 0.0)
    return set_high(leave, leave,
                    fmt::format("x always moves in phase with the base, at {:.3g} m or more", smallest_high), result);
  if (after < apart * largest_low)
    return set_high(infinity, infinity,
                    fmt::format("amplitudes in phase with the base ({:.3g} m) and against it ({:.3g} m) are not apart: "
                                "one regime",
                                after, largest_low),
                    result);
  set_high(std::max(0.625 * after, 1.1 * largest_low), leave,
           fmt::format("{} jump{} up, from at most {:.3g} m against the base to {:.3g} m in phase with it",
                       jumps.size(), jumps.size() == 1 ? "" : "s", largest_low, after),
           result);
}

// ---- Without one: a jump is a growth of the envelope.

// Whether the envelope keeps within half of itself over [first, last), which lies in the record.
bool settled(const Eigen::VectorXd& envelope_m, Index first, Index last) {
  if (first < 0 || last > envelope_m.size()) return false;
  const auto interval = envelope_m.segment(first, last - first);
  return interval.maxCoeff() < 1.5 * interval.minCoeff();
}

// Where the envelope grows (sign +1) or falls (-1) by half or more within `reach` samples, away from sticking:
// the steepest index of each.
std::vector<Jump> steepest_changes(const Eigen::VectorXd& envelope_m, const std::vector<bool>& stuck, Index reach,
                                   int sign) {
  std::vector<Jump> found;
  const double least = std::log(1.5);
  double steepest = 0.0;
  for (Index i = reach; i + reach < envelope_m.size(); ++i) {
    const double before = envelope_m(i - reach), after = envelope_m(i + reach);
    const double growth = before > 0.0 && after > 0.0 ? sign * std::log(after / before) : 0.0;
    const bool clear = !stuck[static_cast<std::size_t>(i - reach)] && !stuck[static_cast<std::size_t>(i + reach)] &&
                       !stuck[static_cast<std::size_t>(i)];
    if (growth < least || !clear) {
      steepest = 0.0;
      continue;
    }
    if (steepest == 0.0) found.push_back({});
    if (growth > steepest) found.back() = {i, before, after}, steepest = growth;
  }
  return found;
}

void choose_by_growth(const RegimeSigns& signs, const std::vector<bool>& stuck, Segmentation& result) {
  const Index reach = signs.samples_in(std::max(3.0 * signs.period_s, result.options.envelope_window_s));
  auto up = steepest_changes(signs.envelope_m, stuck, reach, +1);
  const auto down = steepest_changes(signs.envelope_m, stuck, reach, -1);
  const Index settle = signs.samples_in(10.0 * signs.period_s);
  std::erase_if(up, [&](const Jump& jump) {  // what starts from rest, or beats, leaves no regime
    return !settled(signs.envelope_m, jump.at - reach - settle, jump.at - reach);
  });
  if (up.empty()) return set_high(infinity, infinity, "the amplitude never jumps up: one regime of motion", result);
  double largest_below = 0.0, smallest_above = infinity, smallest_high = infinity;
  for (const Jump& jump : up) {
    largest_below = std::max(largest_below, jump.before_m);
    smallest_above = std::min(smallest_above, jump.after_m);
    // High lasts from here to the next fall or stop.
    Index end = signs.num_samples();
    for (const Jump& fall : down)
      if (fall.at > jump.at) end = std::min(end, fall.at - reach);
    for (Index i = jump.at + reach; i < end && !stuck[static_cast<std::size_t>(i)]; ++i)
      smallest_high = std::min(smallest_high, signs.envelope_m(i));
  }
  set_high(std::sqrt(largest_below * std::max(smallest_above, largest_below)), leave_fraction_by_growth * smallest_high,
           fmt::format("{} jump{} up, from at most {:.3g} m to at least {:.3g} m", up.size(), up.size() == 1 ? "" : "s",
                       largest_below, smallest_above),
           result);
}

}  // namespace

bool against_base(const RegimeSigns& signs, Index sample) {
  return signs.phase.size() > 0 && signs.phase(sample) < -clear_phase;
}

void choose_stick(const RegimeSigns& signs, Segmentation& result) {
  SegmentOptions& options = result.options;
  if (options.stick_duration_s == 0.0) options.stick_duration_s = signs.period_s / 20.0;
  if (options.stick_margin_s == 0.0) options.stick_margin_s = signs.base_moves() ? 1.0 : signs.period_s / 6.0;
  if (options.stick_speed_m_per_s > 0.0) return;
  constexpr double fraction = 0.05, noise_stds = 3.0, largest_fraction = 0.3;
  const CycleAmplitudes amplitudes = velocity_amplitudes(signs);
  const double by_motion = fraction * amplitudes.small, by_base = 0.02 * signs.base_speed_m_per_s,
               by_noise = noise_stds * signs.speed_noise_m_per_s;
  // What does not leave its base is stuck to it.
  const bool rests = signs.base_moves() && amplitudes.shown < std::max(by_noise, by_base);
  if (!rests && by_noise > largest_fraction * amplitudes.shown) {
    result.remarks.push_back(
        fmt::format("stops are not looked for: v has {:.2g} m/s of noise beside amplitudes of {:.2g}",
                    signs.speed_noise_m_per_s, amplitudes.shown));
    return;
  }
  const double floor = rests ? std::max(by_noise, by_base) : by_noise;
  options.stick_speed_m_per_s = std::max(by_motion, floor);
  if (options.stick_halt_s == 0.0 && signs.halts_below_hz > 0.0)
    options.stick_halt_s = 0.9 * shortest_halt_s(signs.halts_below_hz);  // all that are detected, whatever the rounding
  result.remarks.push_back(fmt::format(
      "a stop is slower than {:.2g} m/s for {:.2g} s: {}, 5 % of the period of {:.2g} s", options.stick_speed_m_per_s,
      options.stick_duration_s,
      floor <= by_motion ? fmt::format("{:g} % of the smaller velocity amplitudes", 100.0 * fraction)
      : floor > by_noise ? std::string("2 % of the base's velocity, since the payload hardly moves against it")
                         : fmt::format("{:g} times the noise of v", noise_stds),
      signs.period_s));
  if (!signs.mount.is_rigid())
    result.remarks.push_back(fmt::format(
        "the sensors' mount rings at {:.3g} Hz (damping {:.2g}): its ringing is subtracted before stops are looked for",
        signs.mount.frequency_hz, signs.mount.damping));
  if (!signs.reversals.empty())
    result.remarks.push_back(fmt::format(
        "a reversal is a stop where the acceleration below {:.3g} Hz is zero{}", signs.halts_below_hz,
        signs.mount.is_rigid() ? fmt::format(", or fits a halt of {:.2g} s and more", options.stick_halt_s) : ""));
}

void choose_high(const RegimeSigns& signs, const std::vector<bool>& stuck, Segmentation& result) {
  SegmentOptions& options = result.options;
  if (options.high_enter_m > 0.0) {
    if (options.high_leave_m == 0.0) options.high_leave_m = 0.55 * options.high_enter_m;
  } else if (signs.base_moves()) {
    choose_by_phase(signs, stuck, result);
  } else {
    choose_by_growth(signs, stuck, result);
  }
}

}  // namespace dsp
