#include "dsp/regimes/regime_signs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dsp/filter/fft.hpp"
#include "dsp/filter/spectral.hpp"
#include "dsp/regimes/joint_velocity.hpp"

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

// Reversals of v, and what a does there; both behind a rigid mount.
void look_at_reversals(const Motion& motion, const JointVelocity& velocity, RegimeSigns& signs) {
  // High enough for short halts, and below the mains' hum where that is high enough.
  constexpr double per_period = 26.0, enough = 16.0, below_mains_hz = 38.0;
  const double rate_hz = signs.sample_rate_hz;
  double cutoff_hz = per_period / signs.period_s;
  if (below_mains_hz * signs.period_s >= enough) cutoff_hz = std::min(cutoff_hz, below_mains_hz);
  if (cutoff_hz >= 0.4 * rate_hz || cutoff_hz > motion.find("a")->flat_to_hz) return;
  const Index period = signs.samples_in(signs.period_s);
  auto found = sign_changes(signs.velocity_m_per_s, period);
  std::erase_if(found, [&](Index i) { return signs.excluded[static_cast<std::size_t>(i)] != 0; });
  signs.halts_below_hz = cutoff_hz;
  signs.mount = find_mount(motion, signs.velocity_m_per_s, found, cutoff_hz, period);
  if (signs.mount.is_rigid()) {
    signs.reversals = reversals(found, signs.velocity_m_per_s, motion.at("a"),
                                {.sample_rate_hz = rate_hz, .cutoff_hz = cutoff_hz, .samples_per_period = period});
    return;
  }
  // What is left of a mount's ringing is as large as short halts, but not as slow as v.
  Motion undone = motion;
  undo_mount(undone, signs.mount, {1.2 * cutoff_hz, 1.4 * cutoff_hz});
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
  // A payload that hardly leaves its base has no period of its own.
  const Signal* base_speed = motion.find("dr");
  if (base_speed != nullptr)
    signs.base_speed_m_per_s = std::sqrt(2.0 * base_speed->values.squaredNorm() / static_cast<double>(v.size()));
  const bool follows = base_speed != nullptr && v.squaredNorm() < 0.1 * base_speed->values.squaredNorm();
  signs.period_s = mean_period_s(follows ? base_speed->values : v, rate_hz);
  const SpectralBand slow{5.0 / signs.period_s, 6.5 / signs.period_s};
  signs.speed_cutoff_hz = slow.cutoff_hz;
  const bool has_faster = slow.cutoff_hz < rate_hz / 2 && v.size() >= 8;
  if (has_faster) {
    const JointVelocity velocity(motion, slow, signs.period_s);
    signs.speed_noise_m_per_s = velocity.noise_m_per_s();
    signs.velocity_m_per_s = velocity.velocity();
    if (motion.find("a") != nullptr) look_at_reversals(motion, velocity, signs);
  } else {
    signs.velocity_m_per_s = v;
  }
  return signs;
}

}  // namespace dsp
