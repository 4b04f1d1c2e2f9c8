#include "dsp/regimes/regime_signs.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/filter/fft.hpp"
#include "dsp/filter/short_low_pass.hpp"
#include "dsp/filter/spectral.hpp"
#include "dsp/regimes/harmonics.hpp"
#include "dsp/regimes/joint_velocity.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Of a sine of its power.
double amplitude_by_power(const VectorXd& signal) {
  return std::sqrt(2.0 * signal.squaredNorm() / static_cast<double>(signal.size()));
}

/// 1 / the power-weighted mean frequency of v, and of what the base does, within the harmonics of the one that halves
/// the power by frequency, which noise beyond them moves little.
double mean_period_s(const VectorXd& v, const Signal* base_speed, double rate_hz) {
  const RealFft fft(v.size());
  VectorXd power = fft.forward(v).cwiseAbs2();
  if (base_speed != nullptr) power += fft.forward(base_speed->values).cwiseAbs2();
  power(0) = 0.0;
  const VectorXd steps = VectorXd::LinSpaced(power.size(), 0.0, static_cast<double>(power.size() - 1));
  const VectorXd by_frequency = power.array() / steps.array().max(1.0);
  if (power.size() < 2) return 1.0;
  Index half = 1;
  for (double left = 0.5 * by_frequency.sum() - by_frequency(1); left > 0.0;) left -= by_frequency(++half);
  const Index end = std::min(power.size(), static_cast<Index>(num_harmonics * static_cast<double>(half)) + 1);
  const double moment = power.head(end).dot(steps.head(end));
  return moment > 0.0 ? power.head(end).sum() / moment * static_cast<double>(v.size()) / rate_hz : 1.0;
}

// Reversals of v, and what a does there; both behind a rigid mount.
void look_at_reversals(const Motion& motion, const JointVelocity& velocity, const SpectralBand& slow,
                       RegimeSigns& signs) {
  const double rate_hz = signs.sample_rate_hz, cutoff_hz = halt_harmonic / signs.period_s;
  if (ShortLowPass::stops_from_hz(cutoff_hz) >= 0.5 * rate_hz || cutoff_hz > motion.find("a")->flat_to_hz) return;
  const Index period = signs.samples_in(signs.period_s);
  auto found = sign_changes(signs.velocity_m_per_s, period);
  std::erase_if(found, [&](Index i) { return signs.excluded[static_cast<std::size_t>(i)] != 0; });
  signs.halts_below_hz = cutoff_hz;
  signs.mount = find_mount(motion, signs.velocity_m_per_s, found, cutoff_hz, period);
  if (signs.mount.is_rigid()) {
    signs.reversals =
        reversals(found, signs.velocity_m_per_s, motion.at("a"), {.sample_rate_hz = rate_hz, .cutoff_hz = cutoff_hz});
    return;
  }
  // What is left of a mount's ringing is as large as short halts, but not as slow as v.
  Motion undone = motion;
  undo_mount(undone, signs.mount, {slow.cutoff_hz, cutoff_hz});
  signs.velocity_m_per_s = velocity.of(undone);
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
  const Signal* base_speed = motion.find("dr");
  if (base_speed != nullptr) signs.base_speed_m_per_s = amplitude_by_power(base_speed->values);
  if (const Signal* force = motion.find("f"); force != nullptr && base_speed == nullptr) {
    signs.force = force->values;
    signs.force_span = force->values.maxCoeff() - force->values.minCoeff();
  }
  signs.base_rests = !(signs.base_speed_m_per_s > sensors_agree * amplitude_by_power(v));
  signs.period_s = mean_period_s(v, base_speed, rate_hz);
  const SpectralBand slow = harmonics_band(signs.period_s);
  signs.speed_cutoff_hz = waves_per_period / signs.period_s;
  const bool has_faster = slow.cutoff_hz < rate_hz / 2 && v.size() >= 8;
  if (has_faster) {
    const JointVelocity velocity(motion, slow, signs.period_s);
    signs.speed_noise_m_per_s = velocity.noise_m_per_s();
    signs.velocity_m_per_s = velocity.velocity();
    if (motion.find("a") != nullptr) look_at_reversals(motion, velocity, slow, signs);
  } else {
    signs.velocity_m_per_s = v;
    signs.is_coarse = true;
    signs.speed_cutoff_hz = std::min(motion.find("v")->flat_to_hz, 0.5 * rate_hz);
  }
  return signs;
}

}  // namespace dsp
