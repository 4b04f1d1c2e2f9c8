#include "dsp/regimes/joint_velocity.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "dsp/regimes/half_cycles.hpp"
#include "support/motion.hpp"
#include "support/signals.hpp"

namespace test_regimes_joint_velocity {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 256.0, period_s = 0.625, two_pi = 2.0 * std::numbers::pi;
constexpr Index n = 300 * 256;
const dsp::SpectralBand band{5.0 / period_s, 6.5 / period_s}, all{60.0, 90.0};

struct Measured {
  dsp::Motion motion;
  VectorXd v;  ///< without noise
};

/// A tone of 8 mm with its third harmonic, read by a displacement and an acceleration sensor.
Measured measured(double noise_m, double noise_m_per_s2) {
  VectorXd x(n), a(n);
  Measured result{{}, VectorXd(n)};
  for (Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / rate_hz;
    x(i) = result.v(i) = a(i) = 0.0;
    for (const auto& [f, amplitude] : {std::pair{1.6, 8e-3}, {4.8, 4e-4}}) {
      x(i) += amplitude * std::sin(two_pi * f * t);
      result.v(i) += amplitude * two_pi * f * std::cos(two_pi * f * t);
      a(i) -= amplitude * std::pow(two_pi * f, 2) * std::sin(two_pi * f * t);
    }
  }
  x += support::gaussian(n, 1, noise_m);
  a += support::gaussian(n, 2, noise_m_per_s2);
  result.motion =
      support::motion_of(rate_hz, {{"x", x}, {"v", dsp::ExtendedSpectrum(x, rate_hz).derivative(1, all)}, {"a", a}});
  for (dsp::Signal& signal : result.motion.signals)
    if (signal.name == "v") signal.flat_to_hz = all.rolloff_hz;
  return result;
}

double error_rms(const Measured& measured, const VectorXd& velocity) {
  const Index edge = 512;  // leans on a prediction
  return std::sqrt((velocity - measured.v).segment(edge, n - 2 * edge).squaredNorm() /
                   static_cast<double>(n - 2 * edge));
}

}  // namespace

TEST_CASE("the velocity of two sensors has the noise that it is said to have, and less than that of one",
          "[dsp][regimes]") {
  for (const double noise_m : {1e-6, 1e-5, 1e-4})
    for (const double noise_m_per_s2 : {0.003, 0.03, 0.3}) {
      INFO("noise " << noise_m << " m and " << noise_m_per_s2 << " m/s^2");
      Measured both = measured(noise_m, noise_m_per_s2);
      const dsp::JointVelocity joint(both.motion, band, period_s);
      const double error = error_rms(both, joint.of(both.motion));
      CHECK(error == Approx(joint.noise_m_per_s()).epsilon(0.35));  // weights are by steps
      Measured one = both;
      one.motion.signals.pop_back();
      const dsp::JointVelocity alone(one.motion, band, period_s);
      CHECK(error_rms(one, alone.of(one.motion)) == Approx(alone.noise_m_per_s()).epsilon(0.15));
      CHECK(joint.noise_m_per_s() < alone.noise_m_per_s());
    }
}

TEST_CASE("an acceleration computed from x adds nothing to its velocity", "[dsp][regimes]") {
  Measured one = measured(1e-5, 0.0);
  dsp::Signal& a = one.motion.signals.back();
  a.values = dsp::ExtendedSpectrum(one.motion.at("x"), rate_hz).derivative(2, all);
  const dsp::JointVelocity unsaid(one.motion, band, period_s);
  a.flat_to_hz = all.rolloff_hz;
  const dsp::JointVelocity said(one.motion, band, period_s);
  CHECK(said.noise_m_per_s() == unsaid.noise_m_per_s());
  CHECK(error_rms(one, said.of(one.motion)) == Approx(said.noise_m_per_s()).epsilon(0.15));
}

TEST_CASE("a velocity of its own sensor has the noise of that sensor", "[dsp][regimes]") {
  Measured both = measured(1e-4, 1e3);
  for (dsp::Signal& signal : both.motion.signals)
    if (signal.name == "v") {
      signal.values = both.v + support::gaussian(n, 3, 1e-3);
      signal.flat_to_hz = std::numeric_limits<double>::infinity();
    }
  const dsp::JointVelocity joint(both.motion, band, period_s);
  const double error = error_rms(both, joint.of(both.motion));
  CHECK(error < 5e-4);  // white, below 10 Hz of 128: 0.28e-3
  CHECK(joint.noise_m_per_s() == Approx(error).epsilon(0.35));
}

TEST_CASE("where no band is left to see noise in, the velocity is that of the displacement", "[dsp][regimes]") {
  Measured both = measured(1e-6, 0.03);
  const double short_s = 13.2 / rate_hz;  // the sixth harmonic is below 0.45 of the rate, the tenth is not
  const dsp::SpectralBand below{5.0 / short_s, 6.5 / short_s};
  const VectorXd v = dsp::JointVelocity(both.motion, below, short_s).of(both.motion);
  REQUIRE(v.allFinite());
  CHECK(error_rms(both, v) < 0.1);
}

TEST_CASE("noise is measured in what is kept", "[dsp][regimes]") {
  constexpr double noise_m = 1e-5;
  Measured spoilt = measured(noise_m, 0.03);
  spoilt.motion.excluded.assign(static_cast<std::size_t>(n), 0);
  VectorXd x = spoilt.motion.at("x");
  for (double at_s = 1.0; at_s < 150.0; at_s += 2.0 + std::sin(at_s))  // a cable drops out, at no time of the motion's
    for (Index i = std::lround(at_s * rate_hz), end = i + 20; i < end; ++i)
      x(i) = 0.02, spoilt.motion.excluded[static_cast<std::size_t>(i)] = 1;
  // Of thousand ordinates in the band and more, a median; each break has a hundred thousand times the noise's power.
  const double of_noise = 2.0 * noise_m * noise_m / rate_hz;
  CHECK(dsp::density_beyond_harmonics(spoilt.motion, x, period_s) / of_noise == Approx(1.0).epsilon(0.15));
  CHECK(dsp::density_beyond_harmonics({.sample_rate_hz = rate_hz}, x, period_s) / of_noise > 100.0);
}

}  // namespace test_regimes_joint_velocity
