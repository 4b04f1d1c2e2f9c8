#pragma once
#include <functional>
#include <vector>

namespace sim {

/// The steady answer of an oscillator to a sine of one frequency at its base (Fig. 11 of [QZS23]).
struct ResponsePoint {
  double frequency_hz = 0.0;
  double x_m = 0.0, y_m = 0.0;  ///< half of max - min over the last periods of the dwell
  double phase_rad = 0.0;       ///< of x's fundamental against the base's displacement, in (-pi, pi]; NaN: locked
  double stuck_fraction = 0.0;  ///< of that time
  bool locked = false;          ///< no motion relative to the base at all
};

/// What happens on the way: first frequency at which ... ; NaN where it does not.
struct ResponseJumps {
  double unlock_rising_hz = 0.0;      ///< ... the locked payload breaks loose, on the way up
  double jump_up_rising_hz = 0.0;     ///< ... the sliding payload reaches an upper branch, on the way up
  double jump_down_rising_hz = 0.0;   ///< ... the upper branch is lost, on the way up
  double jump_up_falling_hz = 0.0;    ///< ... an upper branch is reached, on the way down
  double jump_down_falling_hz = 0.0;  ///< ... it is lost, on the way down
  double lock_falling_hz = 0.0;       ///< ... the payload stays locked, on the way down
};

/// The same frequencies walked up and down, each from the state the one before left behind.
struct FrequencyResponse {
  std::vector<ResponsePoint> up, down;
  ResponseJumps jumps;
};

enum class SweepChange { none, unlock, lock, jump_up, jump_down };
/// What lies between one frequency's answer and the next's, amplitudes further apart than `factor` being a jump.
[[nodiscard]] SweepChange change_between(const ResponsePoint& before, const ResponsePoint& here, double factor);
/// The first of each change, at the frequency after it.
[[nodiscard]] ResponseJumps find_jumps(const std::vector<ResponsePoint>& up, const std::vector<ResponsePoint>& down,
                                       double factor);
/// Of the largest x. Throws std::invalid_argument for no points.
[[nodiscard]] ResponsePoint peak(const std::vector<ResponsePoint>& points);

struct FrequencyResponseOptions {
  double from_hz = 0.5, to_hz = 1.9, step_hz = 0.01;
  double amplitude_m = 4.5e-3, dwell_s = 40.0, transition_s = 3.0;
  double measured_fraction = 0.25;  ///< of the dwell, at its end
  double jump_factor = 1.4;         ///< amplitudes of neighbouring frequencies further apart than this are a jump
  std::function<void()> poll = {};  ///< called now and then; may throw to stop
};

/// from_hz, from_hz + step_hz ... to_hz. Throws std::invalid_argument for frequencies that make no sweep.
[[nodiscard]] std::vector<double> sweep_frequencies(const FrequencyResponseOptions& options);

}  // namespace sim
