#include "dsp/filter/short_low_pass.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace test_filter_short_low_pass {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 256.0, cutoff_hz = 32.0;

VectorXd tone(double f_hz) {
  return VectorXd::NullaryExpr(
      400, [&](Index i) { return std::cos(2.0 * std::numbers::pi * f_hz * static_cast<double>(i - 200) / rate_hz); });
}

}  // namespace

TEST_CASE("a short low-pass keeps slow tones, stops fast ones and delays none", "[dsp][short_low_pass]") {
  const dsp::ShortLowPass low_pass(cutoff_hz, rate_hz);
  CHECK(low_pass.reach() < 30);
  // Kaiser's design promises 40 dB: 1 %.
  for (const double f_hz : {0.0, 5.0, 25.0}) {
    const VectorXd passed = low_pass(tone(f_hz), 150, 100);
    CHECK((passed - tone(f_hz).segment(150, 100)).cwiseAbs().maxCoeff() < 0.012);
  }
  for (const double f_hz : {39.0, 60.0, 120.0}) CHECK(low_pass(tone(f_hz), 150, 100).cwiseAbs().maxCoeff() < 0.012);
}

TEST_CASE("what a leap becomes behind the low-pass is what its samples become", "[dsp][short_low_pass]") {
  const dsp::ShortLowPass low_pass(cutoff_hz, rate_hz);
  // Switched on at a time between samples, and sampled by means over each, which delays nothing: the second
  // computation is the filter's own sum. A mean takes 1 - sinc(32 / 256) off the highest tones, 3 %.
  const double position = 200.37;
  for (int power = 0; power < 3; ++power) {
    const auto integral = [&](double t) { return t <= 0.0 ? 0.0 : std::pow(t, power + 1) / (power + 1); };
    const VectorXd sampled = VectorXd::NullaryExpr(400, [&](Index i) {
      const double t = static_cast<double>(i) - position;
      return integral(t + 0.5) - integral(t - 0.5);
    });
    const VectorXd passed = low_pass(sampled, 180, 40);
    const double scale = std::pow(10.0, power);
    for (Index i = 0; i < 40; ++i)
      CHECK(low_pass.switched_on(power, static_cast<double>(180 + i) - position) ==
            Approx(passed(i)).margin(0.03 * scale));
    CHECK(low_pass.switched_on(power, -100.0) == 0.0);
    CHECK(low_pass.switched_on(power, 50.0) == Approx(low_pass.passed(power, 50.0)));
  }
  // An even kernel: what comes after a leap's middle mirrors what comes before.
  for (const double t : {0.3, 2.0, 7.5})
    CHECK(low_pass.switched_on(0, t) + low_pass.switched_on(0, -t) == Approx(1.0).margin(1e-9));
}

TEST_CASE("a short low-pass needs a cut-off within the band", "[dsp][short_low_pass]") {
  CHECK_THROWS_AS(dsp::ShortLowPass(0.0, rate_hz), std::invalid_argument);
  CHECK_THROWS_AS(dsp::ShortLowPass(128.0, rate_hz), std::invalid_argument);
}

}  // namespace test_filter_short_low_pass
