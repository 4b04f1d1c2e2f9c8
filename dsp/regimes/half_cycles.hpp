#pragma once
#include <Eigen/Core>
#include <vector>

#include "dsp/sensors/motion.hpp"

namespace dsp {

/// Half a cycle of what drives a motion, judged by the whole cycle about its middle.
struct HalfCycle {
  Eigen::Index first = 0, middle = 0, last = 0;  ///< samples right behind three zeros of the drive in a row
  double correlation = 0.0;                      ///< sum over [first, last) of x times the drive, x about its mean
  double cosine = 0.0;     ///< of the phase of x against the drive: the correlation over that of two sines in phase
  double amplitude = 0.0;  ///< of x: of a sine of its power
  double phase_variance = 0.0;  ///< by noise (rad^2); infinite where x or the drive is nothing but noise
  double drive_level = 0.0;     ///< logarithm of the drive's rms
  double drive_variance = 0.0;  ///< of that, by noise
};

/// The half cycles of the base's displacement (r, else what ddr says of it), else of the force f, of a motion of this
/// dominant period. None where no such signal moves.
[[nodiscard]] std::vector<HalfCycle> half_cycles(const Motion& motion, double period_s);

/// The same of x itself, whatever drives it.
[[nodiscard]] std::vector<HalfCycle> own_half_cycles(const Motion& motion, double period_s);

/// One-sided power density of what is no motion in `signal`, one of the motion's: from twice to three times its
/// harmonics, in runs of kept samples, as an exclusion breaks a signal in all frequencies; in all samples where none
/// lasts for a period.
[[nodiscard]] double density_beyond_harmonics(const Motion& motion, const Eigen::VectorXd& signal, double period_s);

}  // namespace dsp
