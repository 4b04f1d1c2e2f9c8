#include "dsp/segment_regimes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <stdexcept>
#include <utility>

#include "dsp/fft.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Labels = std::vector<Regime>;

constexpr std::array<std::pair<Regime, std::string_view>, 4> names{
    {{Regime::low, "low"}, {Regime::high, "high"}, {Regime::stick, "stick"}, {Regime::excluded, "excluded"}}};

Index samples_in(double seconds, const Motion& motion) {
  return std::max<Index>(1, static_cast<Index>(std::lround(seconds * motion.sample_rate_hz)));
}

VectorXd moving_mean(const VectorXd& x, Index half) {
  VectorXd sum(x.size() + 1);
  sum(0) = 0.0;
  const double centre = x.mean();  // summed about the mean: no digits lost to an offset
  for (Index i = 0; i < x.size(); ++i) sum(i + 1) = sum(i) + (x(i) - centre);
  VectorXd mean(x.size());
  for (Index i = 0; i < x.size(); ++i) {
    const Index from = std::max<Index>(0, i - half), to = std::min(x.size(), i + half + 1);
    mean(i) = centre + (sum(to) - sum(from)) / static_cast<double>(to - from);
  }
  return mean;
}

// Largest value within +-half samples of each, in one pass with a monotone queue.
VectorXd moving_max(const VectorXd& x, Index half) {
  VectorXd largest(x.size());
  std::deque<Index> queue;
  for (Index i = 0, next = 0; i < x.size(); ++i) {
    for (; next < std::min(x.size(), i + half + 1); ++next) {
      while (!queue.empty() && x(queue.back()) <= x(next)) queue.pop_back();
      queue.push_back(next);
    }
    while (queue.front() < i - half) queue.pop_front();
    largest(i) = x(queue.front());
  }
  return largest;
}

VectorXd envelope(const VectorXd& x, const Motion& motion, const SegmentOptions& options) {
  const VectorXd swing = x - moving_mean(x, samples_in(options.baseline_window_s / 2, motion));
  const Index half = samples_in(options.envelope_window_s / 2, motion);
  return 0.5 * (moving_max(swing, half) + moving_max(-swing, half));
}

// 1 / the power-weighted mean frequency of v between 0.1 Hz and an eighth of the rate.
double dominant_period_s(const VectorXd& v, const Motion& motion) {
  const Eigen::VectorXcd spectrum = RealFft(v.size()).forward(v);
  double power = 0.0, moment = 0.0;
  for (Index k = 1; k < spectrum.size(); ++k) {
    const double f = static_cast<double>(k) * motion.sample_rate_hz / static_cast<double>(v.size());
    if (f < 0.1 || f > motion.sample_rate_hz / 8) continue;
    power += std::norm(spectrum(k));
    moment += std::norm(spectrum(k)) * f;
  }
  return moment > 0.0 ? power / moment : 1.0;
}

// Velocity amplitude that nine of ten cycles in motion exceed; a cycle moves if it reaches a tenth of the record's.
double small_velocity_amplitude(const VectorXd& v, double period_s, const Motion& motion) {
  const Index period = samples_in(period_s, motion);
  std::vector<double> peaks;
  for (Index first = 0; first + period <= v.size(); first += period)
    peaks.push_back(v.segment(first, period).cwiseAbs().maxCoeff());
  if (peaks.empty()) return v.cwiseAbs().maxCoeff();
  std::sort(peaks.begin(), peaks.end());
  const double bar = 0.1 * peaks[peaks.size() * 9 / 10];
  peaks.erase(peaks.begin(), std::lower_bound(peaks.begin(), peaks.end(), bar));
  return peaks.empty() ? 0.0 : peaks[peaks.size() / 10];
}

// Stops of at least stick_duration_s, dilated by the margin.
std::vector<bool> stick_mask(const VectorXd& v, const Motion& motion, const SegmentOptions& options) {
  std::vector<bool> stuck(static_cast<std::size_t>(v.size()), false);
  constexpr Index least = 3;  // fewer samples can lie about a reversal
  const Index shortest = std::max(least, samples_in(options.stick_duration_s, motion)),
              margin = samples_in(options.stick_margin_s, motion);
  for (Index i = 0; i < v.size();) {
    Index end = i;
    while (end < v.size() && std::abs(v(end)) < options.stick_speed_m_per_s) ++end;
    if (end - i >= shortest)
      std::fill(stuck.begin() + std::max<Index>(0, i - margin), stuck.begin() + std::min(v.size(), end + margin), true);
    i = end + 1;
  }
  return stuck;
}

struct Jump {
  Index at = 0;
  double before_m = 0.0, after_m = 0.0;
};

// Places where the envelope grows (sign +1) or falls (-1) by half or more within `reach` samples, away from sticking:
// the steepest place of each.
std::vector<Jump> jumps(const VectorXd& envelope_m, const std::vector<bool>& stuck, Index reach, int sign) {
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

void choose_stick(const VectorXd& v, const Motion& motion, double period_s, Segmentation& result) {
  SegmentOptions& options = result.options;
  if (options.stick_duration_s == 0.0) options.stick_duration_s = period_s / 13.0;
  if (options.stick_speed_m_per_s > 0.0) return;
  options.stick_speed_m_per_s = 0.08 * small_velocity_amplitude(v, period_s, motion);
  result.remarks.push_back(
      fmt::format("a stop is slower than {:.2g} m/s for {:.2g} s: 8 % of the smaller velocity amplitudes, "
                  "a thirteenth of the period of {:.2g} s",
                  options.stick_speed_m_per_s, options.stick_duration_s, period_s));
}

void choose_high(const std::vector<bool>& stuck, double period_s, const Motion& motion, Segmentation& result) {
  SegmentOptions& options = result.options;
  if (options.high_enter_m > 0.0) {
    if (options.high_leave_m == 0.0) options.high_leave_m = 0.55 * options.high_enter_m;
    return;
  }
  const Index reach = samples_in(std::max(3.0 * period_s, options.envelope_window_s), motion);
  const auto up = jumps(result.envelope_m, stuck, reach, +1), down = jumps(result.envelope_m, stuck, reach, -1);
  if (up.empty()) {
    options.high_enter_m = options.high_leave_m = std::numeric_limits<double>::infinity();
    result.remarks.emplace_back("the amplitude never jumps up: one regime of motion");
    return;
  }
  double largest_below = 0.0, smallest_above = std::numeric_limits<double>::infinity(), smallest_high = smallest_above;
  for (const Jump& jump : up) {
    largest_below = std::max(largest_below, jump.before_m);
    smallest_above = std::min(smallest_above, jump.after_m);
    // High lasts from here to the next fall or stop.
    Index end = result.envelope_m.size();
    for (const Jump& fall : down)
      if (fall.at > jump.at) end = std::min(end, fall.at - reach);
    for (Index i = jump.at + reach; i < end && !stuck[static_cast<std::size_t>(i)]; ++i)
      smallest_high = std::min(smallest_high, result.envelope_m(i));
  }
  options.high_enter_m = std::sqrt(largest_below * std::max(smallest_above, largest_below));
  if (options.high_leave_m == 0.0) options.high_leave_m = std::min(0.85 * smallest_high, options.high_enter_m);
  result.remarks.push_back(fmt::format(
      "{} jump{} up: high begins above {:.3g} m (between {:.3g} and {:.3g}) and ends below "
      "{:.3g} m",
      up.size(), up.size() == 1 ? "" : "s", options.high_enter_m, largest_below, smallest_above, options.high_leave_m));
}

Labels label(const Motion& motion, const Segmentation& so_far, const std::vector<bool>& stuck) {
  Labels labels(stuck.size(), Regime::low);
  bool high = false;
  for (std::size_t i = 0; i < stuck.size(); ++i) {
    const double level = so_far.envelope_m(static_cast<Index>(i));
    if (level > so_far.options.high_enter_m) high = true;
    if (level < so_far.options.high_leave_m || stuck[i]) high = false;
    labels[i] = stuck[i] ? Regime::stick : high ? Regime::high : Regime::low;
    if (i < motion.excluded.size() && motion.excluded[i] != 0) labels[i] = Regime::excluded;
  }
  return labels;
}

std::vector<Segment> runs(const Labels& labels) {
  std::vector<Segment> segments;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto place = static_cast<Index>(i);
    if (segments.empty() || segments.back().regime != labels[i]) segments.push_back({labels[i], place, place, {}});
    segments.back().last = place + 1;
  }
  return segments;
}

// Short runs join their left neighbour (or become stick between two sticks); what was excluded stays so.
std::vector<Segment> without_short_runs(std::vector<Segment> segments, Index shortest) {
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < segments.size() && !changed; ++i) {
      Segment& run = segments[i];
      if (run.regime == Regime::excluded || run.last - run.first >= shortest) continue;
      const bool has_left = i > 0 && segments[i - 1].regime != Regime::excluded;
      const bool has_right = i + 1 < segments.size() && segments[i + 1].regime != Regime::excluded;
      if (!has_left && !has_right) continue;
      if (run.regime == Regime::stick && !(has_left && has_right)) continue;  // a stop at an end is a stop
      run.regime = segments[has_left ? i - 1 : i + 1].regime;
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

std::string_view to_string(Regime regime) {
  for (const auto& [value, name] : names)
    if (value == regime) return name;
  return "?";
}

Regime regime_from_string(std::string_view name) {
  for (const auto& [value, text] : names)
    if (text == name) return value;
  throw std::invalid_argument("regime must be one of low, high, stick, excluded; got '" + std::string(name) + "'");
}

Segmentation segment_regimes(const Motion& motion, const SegmentOptions& options) {
  if (options.stick_speed_m_per_s < 0.0 || options.stick_duration_s < 0.0 || options.high_enter_m < 0.0 ||
      options.high_leave_m < 0.0 || options.envelope_window_s <= 0.0 || options.baseline_window_s <= 0.0)
    throw std::invalid_argument("segment_regimes: thresholds must not be negative and windows must be positive");
  if (options.high_enter_m > 0.0 && options.high_leave_m > options.high_enter_m)
    throw std::invalid_argument("segment_regimes: high_leave_m lies above high_enter_m");
  const VectorXd &x = motion.at("x"), &v = motion.at("v");
  Segmentation result;
  result.options = options;
  if (x.size() == 0) return result;
  result.envelope_m = envelope(x, motion, options);
  const double period_s = dominant_period_s(v, motion);
  choose_stick(v, motion, period_s, result);
  const std::vector<bool> stuck = stick_mask(v, motion, result.options);
  choose_high(stuck, period_s, motion, result);
  result.segments = without_short_runs(runs(label(motion, result, stuck)), samples_in(options.min_duration_s, motion));
  return result;
}

}  // namespace dsp
