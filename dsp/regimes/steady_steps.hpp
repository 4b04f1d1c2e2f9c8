#pragma once
#include <vector>

#include "dsp/sensors/motion.hpp"

namespace dsp {

/// What an interval of constant frequency and waveform of the drive is good for.
enum class StepTag {
  final,          ///< the end result of its frequency: drive as wanted, response settled
  iteration,      ///< followed at the same frequency by a better setting of the drive
  unsettled,      ///< the response still changes
  off_amplitude,  ///< the drive misses the amplitude of the others
  distorted,      ///< the drive is no pure sine
  disturbed,      ///< holds samples that must not be used
};
[[nodiscard]] std::string_view to_string(StepTag tag);  ///< as the enumerator

/// One interval of a stepped-sine test. Amplitudes are half of max - min of the waveform, harmonics included.
struct SteadyStep {
  double from_s = 0.0, to_s = 0.0;  ///< what was measured: its later part
  double frequency_hz = 0.0;
  double drive = 0.0;             ///< amplitude of the drive's fundamental (m, or the unit of f)
  double drive_distortion = 0.0;  ///< its second and third harmonic, as a fraction
  double x_m = 0.0, y_m = 0.0;    ///< y: NaN where there is none
  double phase_rad = 0.0;         ///< of x's fundamental against the drive's, in (-pi, pi]; NaN: locked
  bool locked = false;            ///< no motion relative to the base
  bool stops = false;             ///< is (nearly) at rest for twice as long as a sine, in every period
  int direction = 0;              ///< of the sweep: 1 up, -1 down, 0 unknown
  StepTag tag = StepTag::final;
};

/// Finds the settings of a stepped-sine test in the drive (r, or f where there is no base) and what the response came
/// to in each; in order of time. Empty for a record that is none. A drive, or a response, is as it should be within
/// one per cent, over six of its periods, or what the drive's own noise does to those where that is more; of fewer than
/// three frequencies there is no test. Throws std::invalid_argument for a motion without x.
[[nodiscard]] std::vector<SteadyStep> find_steady_steps(const Motion& motion);

}  // namespace dsp
