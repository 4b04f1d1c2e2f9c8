#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "dsp/sensors/sensor_consistency.hpp"

namespace dsp {

enum class SensorProblemKind {
  polarity,  ///< the two have opposite signs; which of them is right cannot be seen
  unit,      ///< their ratio is that of two units: millimetres read as metres, g as m/s^2
  gain,      ///< the ratio of their gains is not 1, nor that of two units
  lag,       ///< one of them is late
  cutoff,    ///< the accelerometer's AC-coupling cut-offs are not those that its description says
};
/// "polarity", "unit", "gain", "lag"; "corner" for cutoff, as in the names of checks.
[[nodiscard]] std::string_view to_string(SensorProblemKind kind);

/// Something that a sidecar should say of a channel and does not.
struct SensorProblem {
  SensorProblemKind kind = SensorProblemKind::gain;
  std::string channel;              ///< whose description is to be changed
  std::string sentence;             ///< what was found, with its uncertainty
  double value = 0.0, std = 0.0;    ///< ratio, seconds or Hz
  double limit = 0.0;               ///< a difference smaller than this is not raised
  bool either = false;              ///< which of the two is wrong cannot be seen: `channel` or its partner
  std::string unit;                 ///< unit: what the channel's numbers are in; gain: what they are said to be in, SI
  double sensitivity_factor = 1.0;  ///< unit and gain: what the channel's sensitivity is to be multiplied by
  double delay_s = 0.0;             ///< lag: to be added to the channel's delay
  std::vector<double> highpass_hz;  ///< cutoff: what the channel's highpass should be
};

/// What a relation between two sensors shows, in the order of the kinds; empty where none was found. Raised where it
/// exceeds four standard deviations and a floor that clean records stay below: 0.3 % of gain, 50 us of lag, 5 % of the
/// declared cut-offs (their sum is what shows above them) and 0.02 Hz. Of a pair compared by sign and scale alone,
/// where the gain differs from 1 by more than four standard deviations of two calibrations of 1 % each and of the
/// estimate can explain, after all that noise in either could have done. `scale`: whose gain is believed.
[[nodiscard]] std::vector<SensorProblem> sensor_problems(const SensorRelation& relation, ScaleReference scale);

}  // namespace dsp
