#pragma once
#include <array>
#include <functional>

#include "sim/ode/driven.hpp"

namespace sim {

/// One degree of freedom driven by a sine u(t) = A cos(2 pi f t): q'' = acceleration(u, q, q', sgn q'). What friction
/// sgn(q') brings holds q at rest while the rest of the forces stays below it (Filippov), or below static_friction.
struct DrivenOscillator {
  using Drive = std::array<double, 3>;  ///< u and its first and second derivatives
  std::function<double(const Drive& drive, double q, double v, double sign)> acceleration;  ///< m/s^2
  bool switches = false;         ///< whether it looks at the sign
  double static_friction = 0.0;  ///< m/s^2; matters where it exceeds what the sign brings at rest
  double x_per_drive = 0.0;      ///< relative motion x = q + x_per_drive u: -1 where q is absolute
  double y_per_drive = 1.0;      ///< absolute motion y = q + y_per_drive u: 0 where q is, or where u is a force
};

struct OscillatorState {
  double q = 0.0, v = 0.0;
  int mode = 0;  ///< sign of q' in this instant, 0: held at rest
};

/// One period of the drive from a state at its crest.
struct OscillatorPeriod {
  OscillatorState end;
  DrivenMotion motion;
};

/// Dormand-Prince 5(4) in num_steps equal steps, so that the end depends smoothly on the start; split where q' changes
/// sign, where q is caught and let go; each of these located to rounding on the step's polynomial. Values that are no
/// longer finite are left to the caller to see.
[[nodiscard]] OscillatorPeriod run_period(const DrivenOscillator& oscillator, double frequency_hz, double amplitude,
                                          const OscillatorState& start, int num_steps);

/// The same from q and q' alone, in the mode that belongs to them, by 40 steps.
[[nodiscard]] DrivenSystem driven_system(DrivenOscillator oscillator);

}  // namespace sim
