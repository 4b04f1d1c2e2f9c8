#include "dsp/regime_signs.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "dsp/fft.hpp"
#include "dsp/spectral.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

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

VectorXd hann(Index n) {
  return VectorXd::NullaryExpr(n, [&](Index i) {
    return 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(n));
  });
}

// 1 / the power-weighted mean frequency of v between 0.1 Hz and an eighth of the rate.
double dominant_period_s(const VectorXd& v, double rate_hz) {
  const Eigen::VectorXcd spectrum = RealFft(v.size()).forward(v);
  double power = 0.0, moment = 0.0;
  for (Index k = 1; k < spectrum.size(); ++k) {
    const double f = static_cast<double>(k) * rate_hz / static_cast<double>(v.size());
    if (f < 0.1 || f > rate_hz / 8) continue;
    power += std::norm(spectrum(k));
    moment += std::norm(spectrum(k)) * f;
  }
  return moment > 0.0 ? power / moment : 1.0;
}

// One-sided power density of what is no motion in x: the median of its periodogram from the tenth to the sixteenth
// harmonic, where the motion has little left. An exponential distribution's median is ln 2 times its mean; a Hann
// window keeps the leap between the record's ends out.
double displacement_noise(const VectorXd& x, double rate_hz, double period_s) {
  const VectorXd window = hann(x.size());
  const Eigen::VectorXcd spectrum = RealFft(x.size()).forward(((x.array() - x.mean()) * window.array()).matrix());
  std::vector<double> levels;
  for (Index k = 1; k < spectrum.size(); ++k) {
    const double f = static_cast<double>(k) * rate_hz / static_cast<double>(x.size());
    if (f >= 10.0 / period_s && f <= std::min(16.0 / period_s, 0.45 * rate_hz))
      levels.push_back(std::norm(spectrum(k)));
  }
  if (levels.empty()) return 0.0;
  const auto middle = levels.begin() + static_cast<std::ptrdiff_t>(levels.size() / 2);
  std::nth_element(levels.begin(), middle, levels.end());
  return 2.0 * *middle / std::numbers::ln2 / (rate_hz * window.squaredNorm());
}

VectorXd phase_between(const VectorXd& x, const VectorXd& r, Index half) {
  const VectorXd xx = moving_mean(x.cwiseAbs2(), half), rr = moving_mean(r.cwiseAbs2(), half),
                 xr = moving_mean(x.cwiseProduct(r), half);
  // A tenth of its largest amplitude, or a fiftieth of x's, is no motion of a base.
  const double still = std::max(0.01 * rr.maxCoeff(), 4e-4 * xx.maxCoeff());
  return VectorXd::NullaryExpr(
      x.size(), [&](Index i) { return rr(i) > still && xx(i) > 0.0 ? xr(i) / std::sqrt(xx(i) * rr(i)) : 0.0; });
}

}  // namespace

Index RegimeSigns::samples_in(double seconds) const {
  return std::max<Index>(1, static_cast<Index>(std::lround(seconds * sample_rate_hz)));
}

RegimeSigns regime_signs(const Motion& motion, const SegmentOptions& options) {
  const VectorXd &x = motion.at("x"), &v = motion.at("v");
  RegimeSigns signs{.sample_rate_hz = motion.sample_rate_hz, .excluded = motion.excluded};
  signs.excluded.resize(static_cast<std::size_t>(x.size()), 0);
  const auto swing_of = [&](const VectorXd& signal) -> VectorXd {
    return signal - moving_mean(signal, signs.samples_in(options.baseline_window_s / 2));
  };
  const VectorXd swing = swing_of(x);
  const Index half = signs.samples_in(options.envelope_window_s / 2);
  signs.envelope_m = 0.5 * (moving_max(swing, half) + moving_max(-swing, half));

  signs.period_s = dominant_period_s(v, motion.sample_rate_hz);
  const SpectralBand slow{5.0 / signs.period_s, 6.5 / signs.period_s};
  if (slow.cutoff_hz < motion.sample_rate_hz / 2 && v.size() >= 8) {
    signs.speed_m_per_s =
        ExtendedSpectrum(v, motion.sample_rate_hz).filtered([&](double f) { return slow.gain(f); }).cwiseAbs();
    // Derived, noise of density S in x has (2 pi f)^2 S.
    signs.speed_noise_m_per_s =
        2.0 * std::numbers::pi *
        std::sqrt(displacement_noise(swing, motion.sample_rate_hz, signs.period_s) * std::pow(slow.cutoff_hz, 3) / 3.0);
  } else {
    signs.speed_m_per_s = v.cwiseAbs();
  }
  if (motion.find("r") != nullptr)
    signs.phase = phase_between(swing, swing_of(motion.at("r")), signs.samples_in(signs.period_s));
  return signs;
}

namespace {

// How long x stood still in [first, last), where it was slower than `slow`: the time spent there less what passing
// through would take at the rate at which v falls from twice that speed before, and rises to it after. What an end of
// the record cuts is passed as it is on the other side.
Index stood_still(const VectorXd& speed, Index first, Index last, double slow, Index reach) {
  Index before = 0, after = 0;
  while (before < reach && first - before > 0 && speed(first - before) < 2.0 * slow) ++before;
  while (after < reach && last - 1 + after < speed.size() - 1 && speed(last - 1 + after) < 2.0 * slow) ++after;
  if (before == reach) before = 0;  // it never moves faster: no passage
  if (after == reach) after = 0;
  if (first == 0) before = after;
  if (last == speed.size()) after = before;
  return last - first - before - after;
}

}  // namespace

std::vector<bool> stick_mask(const RegimeSigns& signs, const SegmentOptions& options) {
  const VectorXd& speed = signs.speed_m_per_s;
  std::vector<bool> stuck(static_cast<std::size_t>(speed.size()), false);
  constexpr Index least = 3;  // fewer samples can lie about a reversal
  const Index shortest = std::max(least, signs.samples_in(options.stick_duration_s)),
              margin = signs.samples_in(options.stick_margin_s), reach = signs.samples_in(signs.period_s / 4.0);
  for (Index i = 0; i < speed.size();) {
    Index end = i;
    while (end < speed.size() && speed(end) < options.stick_speed_m_per_s) ++end;
    if (end - i >= shortest && stood_still(speed, i, end, options.stick_speed_m_per_s, reach) >= shortest)
      std::fill(stuck.begin() + std::max<Index>(0, i - margin), stuck.begin() + std::min(speed.size(), end + margin),
                true);
    i = end + 1;
  }
  return stuck;
}

}  // namespace dsp
