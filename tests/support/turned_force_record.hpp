#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <complex>

#include "dsp/filter/spectral.hpp"
#include "dsp/values/recording.hpp"
#include "support/random.hpp"

namespace support {

/// a = -40 x - 0.8 v - 30 x^3 + f under five tones of 0.6 to 1.3 Hz: the cube reaches to 3.9 Hz. `turn_rad`: phase that
/// the force's channel loses at 4 Hz, with the fourth power of the frequency.
inline dsp::Recording turned_force_record(double turn_rad) {
  constexpr double rate_hz = 12.0;
  constexpr Eigen::Index n = 12'000;
  constexpr std::array tones_hz{0.61, 0.77, 0.93, 1.09, 1.27};
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n), v = x, a = x;
  for (std::size_t i = 0; i < tones_hz.size(); ++i) {
    const double omega = 2.0 * M_PI * tones_hz[i];
    for (Eigen::Index k = 0; k < n; ++k) {
      const double phase = omega * static_cast<double>(k) / rate_hz + 1.7 * static_cast<double>(i * i);
      x(k) += 0.3 * std::sin(phase);
      v(k) += 0.3 * omega * std::cos(phase);
      a(k) -= 0.3 * omega * omega * std::sin(phase);
    }
  }
  const Eigen::VectorXd force = a + 40.0 * x + 0.8 * v + 30.0 * x.array().cube().matrix();
  dsp::Recording recording{.name = "duffing", .sample_rate_hz = rate_hz};
  recording.channels = {{.name = "x", .role = dsp::Role::x, .unit = "m"},
                        {.name = "f", .role = dsp::Role::f, .unit = "N"}};
  recording.samples = 1e-4 * gaussian(n, 2, 71);
  recording.samples.col(0) += x;
  recording.samples.col(1) += dsp::ExtendedSpectrum(force, rate_hz).filtered([&](double f_hz) {
    return std::polar(1.0, -turn_rad * std::pow(f_hz / 4.0, 4));
  });
  return recording;
}

}  // namespace support
