#include "dsp/regimes/regime_signs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dsp/filter/fft.hpp"
#include "dsp/filter/spectral.hpp"
#include "dsp/regimes/half_cycles.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// 1 / the power-weighted mean frequency of v between 0.1 Hz and an eighth of the rate.
double mean_period_s(const VectorXd& v, double rate_hz) {
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

// Reversals of v, which still has its sign, and what a does there; both behind a rigid mount.
void look_at_reversals(const Motion& motion, const Signal& a, const SpectralBand& slow, RegimeSigns& signs) {
  // High enough for short halts, and below the mains' hum where that is high enough.
  constexpr double per_period = 26.0, enough = 16.0, below_mains_hz = 38.0;
  const double rate_hz = signs.sample_rate_hz;
  double cutoff_hz = per_period / signs.period_s;
  if (below_mains_hz * signs.period_s >= enough) cutoff_hz = std::min(cutoff_hz, below_mains_hz);
  if (cutoff_hz >= 0.4 * rate_hz || cutoff_hz > a.flat_to_hz) return;
  const Index period = signs.samples_in(signs.period_s);
  VectorXd& v = signs.speed_m_per_s;
  const auto find_reversals = [&] {
    auto found = sign_changes(v, period);
    std::erase_if(found, [&](Index i) { return signs.excluded[static_cast<std::size_t>(i)] != 0; });
    return found;
  };
  signs.halts_below_hz = cutoff_hz;
  ReversalOptions options{.sample_rate_hz = rate_hz, .cutoff_hz = cutoff_hz, .samples_per_period = period};
  const auto found = find_reversals();
  signs.mount = find_mount(motion, v, found, cutoff_hz, period);
  signs.short_halts = signs.mount.is_rigid();
  if (signs.short_halts) {
    signs.reversals = reversals(found, v, a.values, options);
    return;
  }
  const MountError error = mount_error(motion, signs.mount, slow, {1.2 * cutoff_hz, 1.4 * cutoff_hz});
  v -= error.velocity;
  options.short_halts = false;  // what is left of the ringing is as large
  signs.reversals = reversals(find_reversals(), v, a.values - error.acceleration, options);
}

}  // namespace

Index RegimeSigns::samples_in(double seconds) const {
  return std::max<Index>(1, static_cast<Index>(std::lround(seconds * sample_rate_hz)));
}

RegimeSigns regime_signs(const Motion& motion) {
  const VectorXd& v = motion.at("v");
  const double rate_hz = motion.sample_rate_hz;
  RegimeSigns signs{.sample_rate_hz = rate_hz, .excluded = motion.excluded};
  signs.excluded.resize(static_cast<std::size_t>(v.size()), 0);
  // A payload that hardly leaves its base has no period of its own.
  const Signal* base_speed = motion.find("dr");
  if (base_speed != nullptr)
    signs.base_speed_m_per_s = std::sqrt(2.0 * base_speed->values.squaredNorm() / static_cast<double>(v.size()));
  const bool follows = base_speed != nullptr && v.squaredNorm() < 0.1 * base_speed->values.squaredNorm();
  signs.period_s = mean_period_s(follows ? base_speed->values : v, rate_hz);
  const SpectralBand slow{5.0 / signs.period_s, 6.5 / signs.period_s};
  signs.speed_cutoff_hz = slow.cutoff_hz;
  const bool has_faster = slow.cutoff_hz < rate_hz / 2 && v.size() >= 8;
  if (has_faster)  // derived, noise of density S in x has (2 pi f)^2 S
    signs.speed_noise_m_per_s =
        2.0 * std::numbers::pi *
        std::sqrt(noise_density(motion.at("x"), rate_hz, signs.period_s) * std::pow(slow.cutoff_hz, 3) / 3.0);
  if (has_faster) {
    ExtendedSpectrum spectrum(v, rate_hz);
    spectrum.multiply([&](double f) { return slow.gain(f); });
    signs.speed_m_per_s = std::move(spectrum).signal();
  } else {
    signs.speed_m_per_s = v;
  }
  if (const Signal* a = motion.find("a"); a != nullptr && has_faster) look_at_reversals(motion, *a, slow, signs);
  signs.speed_m_per_s = signs.speed_m_per_s.cwiseAbs();
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
  const auto stop = [&](Index first, Index last) {
    std::fill(stuck.begin() + std::max<Index>(0, first - margin), stuck.begin() + std::min(speed.size(), last + margin),
              true);
  };
  // Slow for a moment, but reversing at once by the acceleration: noise of v.
  const std::vector<Reversal>& reversals = signs.reversals;
  const auto reverses_at_once = [&](Index first, Index last) {
    const auto in = std::lower_bound(reversals.begin(), reversals.end(), first,
                                     [](const Reversal& reversal, Index index) { return reversal.at < index; });
    return last - first < reach && in != reversals.end() && in->at < last && in->at_once;
  };
  for (Index i = 0; i < speed.size();) {
    Index end = i;
    while (end < speed.size() && speed(end) < options.stick_speed_m_per_s) ++end;
    if (end - i >= shortest && !reverses_at_once(i, end) &&
        stood_still(speed, i, end, options.stick_speed_m_per_s, reach) >= shortest)
      stop(i, end);
    i = end + 1;
  }
  for (const Reversal& reversal : reversals)
    if (options.stick_halt_s > 0.0 && reversal.halt_s >= options.stick_halt_s)
      stop(reversal.at, reversal.at + signs.samples_in(reversal.halt_s));
  return stuck;
}

}  // namespace dsp
