#pragma once
#include <memory>
#include <string>
#include <vector>

#include "sim/qzs_rig.hpp"

namespace sim {

/// The steady answer of the rig to a sine of one frequency at its base (Fig. 11 of [QZS23]).
struct ResponsePoint {
  double frequency_hz = 0.0;
  double x_m = 0.0, y_m = 0.0;  ///< half of max - min over the last periods of the dwell
  double stuck_share = 0.0;     ///< of that time
  bool locked = false;          ///< no motion relative to the base at all
};

/// The same frequencies walked up and down, each from the state the one before left behind.
struct FrequencyResponse {
  std::vector<ResponsePoint> up, down;
  /// First frequency at which ... ; NaN where it does not happen.
  double unlock_up_hz = 0.0;  ///< ... the locked payload breaks loose, on the way up
  double fall_up_hz = 0.0;    ///< ... the upper branch is lost, on the way up
  double jump_down_hz = 0.0;  ///< ... the upper branch is reached, on the way down
  double lock_down_hz = 0.0;  ///< ... the payload stays locked, on the way down
};

struct FrequencyResponseOptions {
  double from_hz = 0.5, to_hz = 1.9, step_hz = 0.01;
  double amplitude_m = 4.5e-3, dwell_s = 40.0, transition_s = 3.0;
  double measured_share = 0.25;  ///< of the dwell, at its end
  double jump_factor = 1.4;      ///< amplitudes of neighbouring frequencies further apart than this are a jump
};

/// Throws std::invalid_argument for frequencies that make no sweep.
[[nodiscard]] FrequencyResponse frequency_response(const QzsParameters& parameters,
                                                   const FrequencyResponseOptions& options = {});

}  // namespace sim
