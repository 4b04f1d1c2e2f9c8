#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "dsp/filter/spectral.hpp"
#include "dsp/sensors/motion.hpp"

namespace dsp {

/// Displacement and acceleration sensors tell the same velocity: one with its noise derived, which grows with
/// frequency, the other with its noise integrated, which falls. Each frequency has both by the inverse of their noise,
/// the best linear unbiased estimate: on the rig at thirtyfold noise a sixth of the noise that v of the lasers has
/// below 10 Hz.
class JointVelocity {
 public:
  /// Noise is that of x, or of a v of its own sensor, and of a as it is beyond the harmonics; of a
  /// what the two differ by beyond that of x where it is more, in steps of one over the period, as sensors drift:
  /// excluded samples apart. Without an a of its own sensor, v alone. `motion` needs x and v.
  JointVelocity(const Motion& motion, const SpectralBand& band, double period_s);
  /// Below the band's end, of the motion.
  [[nodiscard]] Eigen::VectorXd velocity() const { return combined(v_, a_ ? &*a_ : nullptr); }
  /// The same of one whose sensors are corrected.
  [[nodiscard]] Eigen::VectorXd of(const Motion& motion) const;
  /// rms
  [[nodiscard]] double noise_m_per_s() const;

 private:
  [[nodiscard]] Eigen::VectorXd combined(const ExtendedSpectrum& v, const ExtendedSpectrum* a) const;
  [[nodiscard]] double density_of_v(double frequency_hz) const;
  [[nodiscard]] double weight_of_a(double frequency_hz) const;

  SpectralBand band_;
  ExtendedSpectrum v_;
  std::optional<ExtendedSpectrum> a_;  ///< none: v alone
  double step_hz_, density_of_x_, density_of_v_ = 0.0, density_of_a_ = 0.0;
  bool of_its_own_;                            ///< v is that of a sensor
  std::vector<double> density_of_difference_;  ///< by steps; empty: v alone
};

}  // namespace dsp
