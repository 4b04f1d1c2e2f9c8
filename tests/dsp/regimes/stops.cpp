#include "dsp/regimes/stops.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

namespace test_regimes_stops {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 256.0, period_s = 0.625;
const dsp::SegmentOptions options{.stick_speed_m_per_s = 2e-3, .stick_duration_s = period_s / 100.0};

double half_sine(double u) {
  return std::sin(std::numbers::pi * u);
}

/// v of half waves of 0.08 m/s, without a low-pass, between which the motion rests for halt_s. Their course is from 0
/// to 1.
dsp::RegimeSigns half_waves(double halt_s, double (*course)(double) = half_sine) {
  dsp::RegimeSigns signs{.sample_rate_hz = rate_hz, .period_s = period_s, .speed_cutoff_hz = rate_hz};
  signs.velocity_m_per_s = VectorXd::Zero(20 * 256);
  const double half_s = 0.5 * period_s;
  for (Index i = 0; i < signs.num_samples(); ++i) {
    const double halves = static_cast<double>(i) / rate_hz / (half_s + halt_s),
                 t = std::fmod(halves, 1.0) * (half_s + halt_s);
    if (t < half_s) signs.velocity_m_per_s(i) = 0.08 * course(t / half_s) * (std::fmod(halves, 2.0) < 1.0 ? 1 : -1);
  }
  return signs;
}

double fraction_stuck(const std::vector<bool>& stuck) {
  return static_cast<double>(std::count(stuck.begin(), stuck.end(), true)) / static_cast<double>(stuck.size());
}

}  // namespace

TEST_CASE("what passes straight through zero does not stop, and what rests stops for as long as it rests",
          "[dsp][regimes]") {
  CHECK(fraction_stuck(dsp::stick_mask(half_waves(0.0), options)) == 0.0);
  for (const double halt_s : {0.012, 0.03, 0.1}) {
    INFO("halts of " << halt_s << " s");
    const double rests = halt_s / (0.5 * period_s + halt_s), sample = 1.0 / rate_hz / (0.5 * period_s + halt_s);
    CHECK(fraction_stuck(dsp::stick_mask(half_waves(halt_s), options)) == Approx(rests).margin(sample));
  }
}

TEST_CASE("what comes loose by degrees has stopped until its speed begins to rise", "[dsp][regimes]") {
  const auto by_degrees = [](double u) { return 6.75 * u * u * (1.0 - u); };  // the largest is 1
  const double halt_s = 0.1, whole_s = 0.5 * period_s + halt_s, sample = 1.0 / rate_hz / whole_s;
  CHECK(fraction_stuck(dsp::stick_mask(half_waves(halt_s, by_degrees), options)) ==
        Approx(halt_s / whole_s).margin(sample));
}

TEST_CASE("what touches zero and goes on as it came does not stop, unless for long", "[dsp][regimes]") {
  for (const auto& [halt_s, stops] : {std::pair{0.02, false}, {0.1, true}}) {
    dsp::RegimeSigns signs = half_waves(halt_s);
    signs.speed_cutoff_hz = 6.5 / period_s;
    signs.velocity_m_per_s = signs.velocity_m_per_s.cwiseAbs();
    CHECK((fraction_stuck(dsp::stick_mask(signs, options)) > 0.0) == stops);
  }
}

TEST_CASE("a speed between the threshold and twice that does not break a stop", "[dsp][regimes]") {
  dsp::RegimeSigns signs = half_waves(0.1);
  const double whole = fraction_stuck(dsp::stick_mask(signs, options));
  for (Index i = 0; i < signs.num_samples(); ++i)
    if (std::fmod(static_cast<double>(i) / rate_hz, 0.5 * period_s + 0.1) > 0.5 * period_s + 0.05)
      if (signs.velocity_m_per_s(i) == 0.0 && signs.velocity_m_per_s(i - 1) == 0.0) {
        signs.velocity_m_per_s(i - 1) = 3e-3;
        i += 40;
      }
  CHECK(fraction_stuck(dsp::stick_mask(signs, options)) == Approx(whole).epsilon(0.02));
}

TEST_CASE("where noise is as large as the threshold a stop is as long as three of its standard deviations",
          "[dsp][regimes]") {
  dsp::RegimeSigns signs = half_waves(0.012);
  signs.speed_noise_m_per_s = options.stick_speed_m_per_s;
  signs.velocity_m_per_s *= 0.5;  // passages of 5 ms to either side
  CHECK(fraction_stuck(dsp::stick_mask(signs, options)) == 0.0);
  signs.speed_noise_m_per_s = 0.0;
  CHECK(fraction_stuck(dsp::stick_mask(signs, options)) > 0.0);
}

TEST_CASE("a rest that an end of the record cuts reaches to it", "[dsp][regimes]") {
  dsp::RegimeSigns signs = half_waves(0.1);
  const Index half = std::lround(0.5 * period_s * rate_hz);
  VectorXd& v = signs.velocity_m_per_s;
  v.head(2 * half).setZero();
  v.tail(2 * half).setZero();
  const std::vector<bool> stuck = dsp::stick_mask(signs, options);
  CHECK(std::all_of(stuck.begin(), stuck.begin() + 2 * half, [](bool one) { return one; }));
  CHECK(std::all_of(stuck.end() - 2 * half + 2, stuck.end(), [](bool one) { return one; }));
}

TEST_CASE("where the record ends within the harmonics only a rest of a period is told from a lull", "[dsp][regimes]") {
  for (const auto& [halt_s, stops] : {std::pair{0.5 * period_s, false}, {1.2 * period_s, true}}) {
    dsp::RegimeSigns signs = half_waves(halt_s);
    signs.is_coarse = true;
    CHECK((fraction_stuck(dsp::stick_mask(signs, options)) > 0.0) == stops);
  }
}

TEST_CASE("what nothing drives and goes on swinging has not stopped", "[dsp][regimes]") {
  const auto decay = [](double per_period) {
    dsp::RegimeSigns signs = half_waves(0.0);
    for (Index i = 0; i < signs.num_samples(); ++i)
      signs.velocity_m_per_s(i) *= std::exp(-per_period * static_cast<double>(i) / rate_hz / period_s);
    return signs;
  };
  dsp::RegimeSigns signs = decay(0.2);  // over 55 dB; below the threshold from a half on
  CHECK(fraction_stuck(dsp::stick_mask(signs, options)) == 0.0);
  const VectorXd fading = signs.velocity_m_per_s;
  signs.velocity_m_per_s = fading.reverse().eval();
  CHECK(fraction_stuck(dsp::stick_mask(signs, options)) == 0.0);

  // Held from its middle on; in noise; with what moves beside it; where the speed of a stop is given.
  signs.velocity_m_per_s = fading;
  signs.velocity_m_per_s.tail(fading.size() / 2).setZero();
  CHECK(fraction_stuck(dsp::stick_mask(signs, options)) == Approx(0.5).margin(0.25 * period_s / 20.0));
  signs.velocity_m_per_s = fading;
  signs.speed_noise_m_per_s = 0.5e-3;  // three times that is reached at -34 dB of 55
  CHECK(fraction_stuck(dsp::stick_mask(signs, options)) == Approx(1.0 - 34.0 / 55.0).margin(0.03));
  signs.speed_noise_m_per_s = 0.0;
  signs.force = VectorXd::NullaryExpr(fading.size(), [](Index i) { return std::sin(0.05 * static_cast<double>(i)); });
  signs.force_span = 2.0;
  CHECK(fraction_stuck(dsp::stick_mask(signs, options)) > 0.4);
  signs.force.setConstant(5.0);
  signs.force_span = 0.0;
  CHECK(fraction_stuck(dsp::stick_mask(signs, options)) == 0.0);
  signs.force.resize(0);
  signs.speed_is_given = true;
  CHECK(fraction_stuck(dsp::stick_mask(signs, options)) > 0.4);
}

TEST_CASE("rests are pauses if there are none but while the force rests, and stops if there are others",
          "[dsp][regimes]") {
  dsp::RegimeSigns signs = half_waves(0.1);
  const double whole = fraction_stuck(dsp::stick_mask(signs, options));
  REQUIRE(whole > 0.1);
  // With a force that rests whenever the motion does, and from a wave before; then with one that never does.
  signs.force = signs.velocity_m_per_s;
  const Index before = std::lround(0.02 * rate_hz);
  for (Index i = 0; i + before < signs.num_samples(); ++i)
    if (signs.velocity_m_per_s(i + before) == 0.0) signs.force(i) = 0.0;
  signs.force_span = 0.16;  // from one half wave's speed to the other's
  CHECK(fraction_stuck(dsp::stick_mask(signs, options)) == 0.0);
  for (Index i = 0; i < signs.num_samples(); ++i)
    signs.force(i) += std::sin(2.0 * std::numbers::pi * static_cast<double>(i) / rate_hz / period_s);
  CHECK(fraction_stuck(dsp::stick_mask(signs, options)) == whole);
}

}  // namespace test_regimes_stops
