#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "dsp/sensors/motion.hpp"
#include "dsp/values/recording.hpp"

// What labelled records are made of.

namespace support {

/// A function of time with two derivatives.
struct DriveValue {
  double value = 0.0, rate = 0.0, second = 0.0;
};

/// A sum of tones, or one whose frequency goes from one value to another in a straight line.
struct Drive {
  struct Tone {
    double amplitude = 0.0, omega = 0.0, phase = 0.0, sweep = 0.0;  ///< sweep: of omega, rad/s^2
  };
  std::vector<Tone> tones;
  double scale = 1.0;
  [[nodiscard]] DriveValue at(double t) const;
};

/// x'' = force_gain f - k x - c v - k3 x^3 - xxv x^2 v - friction sgn(v or y') - z_gain z [- r''],
/// z' = z_stiffness v - z_bend (z_share z |v| + (1 - z_share) |z| v).
struct Oscillator {
  double k = 0.0, c = 0.0, k3 = 0.0, xxv = 0.0, friction = 0.0, force_gain = 0.0;
  double z_gain = 0.0, z_stiffness = 0.0, z_bend = 0.0, z_share = 0.0;
  bool base = false;  ///< the drive is the base's displacement and the friction acts against the ground
  double x0 = 0.0, v0 = 0.0;
  Drive drive;
  double amplitude = 0.0, omega = 0.0;  ///< typical: of x, rad/s

  [[nodiscard]] bool has_z() const { return z_gain != 0.0; }
  /// Of the body with state y, without friction.
  [[nodiscard]] double acceleration(double t, const double* y) const;
};

/// x, v, a, and of f, z or r, dr, ddr, y, dy, ddy what there is, from rest but for x0 and v0.
[[nodiscard]] dsp::Motion motion_of(const Oscillator& p, double duration_s, double rate_hz);

/// The channels of these signals, each with white noise of a standard deviation that is this fraction of its rms.
[[nodiscard]] dsp::Recording recorded(const dsp::Motion& motion, const std::vector<std::string>& names, double noise,
                                      std::uint32_t seed);

}  // namespace support
