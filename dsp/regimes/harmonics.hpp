#pragma once
#include "dsp/filter/spectral.hpp"

/// What is taken for granted of any motion and its sensors.
namespace dsp {

/// A motion has power up to this harmonic of its dominant frequency; what is beyond twice that is noise.
inline constexpr double num_harmonics = 4.0;

/// What is slower than this fraction of the dominant frequency is drift of a sensor.
inline constexpr double drift_below = 0.1;

/// Passes the motion, and nothing of what is noise.
[[nodiscard]] inline SpectralBand harmonics_band(double period_s) {
  return {num_harmonics / period_s, 2.0 * num_harmonics / period_s};
}

/// Waves of its half gain in a period: what is shorter than half of one is not seen behind it.
inline constexpr double waves_per_period = 1.5 * num_harmonics;

/// A halt is looked for in an acceleration up to this harmonic: one of a twentieth of a wave there is a four-hundredth
/// of a period, and the mains' hum lies beyond it for most machines.
inline constexpr double halt_harmonic = 5.0 * num_harmonics;

/// What two sensors of one motion agree within, as they are calibrated: slower than this fraction of it is as good as
/// at rest.
inline constexpr double sensors_agree = 0.03;

/// How many standard deviations noise does not exceed: but once in 370 times.
inline constexpr double noise_stds = 3.0;

/// Variance of what is known to one: a place to a sample, the end of a stop to a wave.
inline constexpr double rounding = 1.0 / 12.0;

}  // namespace dsp
