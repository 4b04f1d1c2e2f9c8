#include "dsp/prepare/recorded_derivatives.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace test_sensors_recorded_derivatives {

using dsp::Role;
using Eigen::Index;

namespace {

constexpr double rate_hz = 200.0;

/// A swing at 1.5 and 4 rad/s with noise on x, and a velocity that lags by so much and reads so many times what it is.
dsp::Recording swing(double lag_s, double gain) {
  dsp::Recording recording{.name = "r", .sample_rate_hz = rate_hz};
  recording.channels = {{.name = "x", .role = Role::x, .unit = "m"}, {.name = "v", .role = Role::v, .unit = "m/s"}};
  recording.samples.resize(12000, 2);
  std::mt19937 random(2);
  std::normal_distribution<double> white(0.0, 1e-5);
  for (Index i = 0; i < recording.samples.rows(); ++i) {
    const double t = static_cast<double>(i) / rate_hz, late = t - lag_s;
    recording.samples(i, 0) = 0.1 * std::sin(1.5 * t) + 0.02 * std::sin(4.0 * t) + white(random);
    recording.samples(i, 1) = gain * (0.15 * std::cos(1.5 * late) + 0.08 * std::cos(4.0 * late)) + white(random);
  }
  return recording;
}

bool keeps_velocity(dsp::Recording recording) {
  dsp::RawSpectrum spectrum(rate_hz, 2, recording.samples.rows());
  spectrum.push(dsp::FrameBlock(recording.samples));
  const auto checks = dsp::drop_unlike_derivatives(recording, spectrum, 5.0);
  CHECK(checks.empty() == (recording.find(Role::v) >= 0));
  return recording.find(Role::v) >= 0;
}

}  // namespace

TEST_CASE("a recorded velocity is kept while it is the displacement's derivative, and no longer") {
  CHECK(keeps_velocity(swing(0.0, 1.0)));
  CHECK(keeps_velocity(swing(0.0, 1.03)));    // a gain is the checks' matter
  CHECK(keeps_velocity(swing(0.0, 1000.0)));  // and so is a unit
  CHECK(keeps_velocity(swing(0.001, 1.0)));   // 0.3 % of the faster tone: no sensor is better
  CHECK_FALSE(keeps_velocity(swing(0.02, 1.0)));
}

}  // namespace test_sensors_recorded_derivatives
