#pragma once
#include <Eigen/Core>
#include <vector>

#include "dsp/regimes/reversals.hpp"
#include "dsp/sensors/motion.hpp"
#include "dsp/sensors/mount.hpp"

namespace dsp {

/// What the regimes of a motion are read from; a value a sample.
struct RegimeSigns {
  double sample_rate_hz = 0.0;
  double period_s = 0.0;             ///< the dominant one
  double speed_cutoff_hz = 0.0;      ///< half gain, 6 / period: a stop of period / 12 is half a wave there
  bool is_coarse = false;            ///< v ends within the harmonics; a lull is told from a rest after a period
  Eigen::VectorXd velocity_m_per_s;  ///< v below it, of all sensors together: joint_velocity.hpp
  double speed_noise_m_per_s = 0.0;  ///< rms of what in it is no motion; 0 where v ends below it
  Eigen::VectorXd force;             ///< f, where it and no base drives the motion
  double force_span = 0.0;           ///< its largest value less its least
  double base_speed_m_per_s = 0.0;   ///< amplitude of a sine of its power; 0 without a base
  bool base_rests = true;            ///< none, or one as good as at rest beside v
  Mount mount;                       ///< whose ringing is taken off v and a before they are looked at
  std::vector<Reversal> reversals;   ///< of v in that band, by a below halts_below_hz; none on a mount that rings
  double halts_below_hz = 0.0;       ///< 0: a does not reach far enough to show halts
  bool speed_is_given = false;       ///< what is slower is a stop, and nothing else shows one
  std::vector<unsigned char> excluded;
  [[nodiscard]] bool base_moves() const { return base_speed_m_per_s > 0.0; }
  [[nodiscard]] Eigen::Index num_samples() const { return velocity_m_per_s.size(); }
  [[nodiscard]] double quarter_period() const { return 0.25 * period_s * sample_rate_hz; }  ///< in samples
  /// At least 1.
  [[nodiscard]] Eigen::Index samples_in(double seconds) const;
};

/// `motion` needs x and v.
[[nodiscard]] RegimeSigns regime_signs(const Motion& motion);

}  // namespace dsp
