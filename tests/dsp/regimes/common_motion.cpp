#include "dsp/regimes/common_motion.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/signals.hpp"

namespace test_sensors_common_motion {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 256.0;

// A base that swings; the payload goes with it from 20 to 50 s, and by itself before and after. Two displacement
// sensors with noise, the payload's with a scale, a drift and an offset of its own.
struct Record {
  dsp::Motion motion;
  dsp::Segmentation segmentation;
};

Record record(double gain, double lead_s, double noise_m, unsigned seed) {
  const Index n = static_cast<Index>(70 * rate_hz);
  const support::SweptHarmonics base{.start_hz = 0.9, .amplitudes = {4.5e-3, 0.0, 5e-5, 0.0}};
  VectorXd t(n), r(n), dr(n), ddr(n), y(n), v(n);
  for (Index i = 0; i < n; ++i) {
    t(i) = static_cast<double>(i) / rate_hz;
    const auto at = base.at(t(i)), ahead = base.at(t(i) + lead_s);
    const bool free = t(i) < 20.0 || t(i) >= 50.0;
    r(i) = at.x, dr(i) = at.v, ddr(i) = at.a;
    v(i) = free ? 0.05 * std::cos(7.0 * t(i)) : 0.0;
    y(i) = gain * ahead.x + 2e-3 + 1e-6 * t(i) + (free ? 0.05 / 7.0 * std::sin(7.0 * t(i)) : 1e-3);
  }
  r += support::gaussian(n, seed, noise_m);
  y += support::gaussian(n, seed + 1, noise_m);
  Record result;
  result.motion = {.sample_rate_hz = rate_hz,
                   .signals = {{"t", "s", t},
                               {"x", "m", y - r},
                               {"v", "m/s", v},
                               {"r", "m", r},
                               {"dr", "m/s", dr},
                               {"ddr", "m/s^2", ddr},
                               {"y", "m", y}},
                   .excluded = std::vector<unsigned char>(static_cast<std::size_t>(n), 0)};
  const auto at = [](double s) { return static_cast<Index>(s * rate_hz); };
  result.segmentation.segments = {
      {dsp::Regime::low, 0, at(19)}, {dsp::Regime::stick, at(19), at(51)}, {dsp::Regime::low, at(51), n}};
  return result;
}

}  // namespace

TEST_CASE("bodies that move as one tell the relative gain and lag of their displacement sensors",
          "[dsp][common_motion]") {
  const double gain = 1.007, lead_s = 30e-6;
  double gains = 0.0, leads = 0.0;
  constexpr unsigned num_seeds = 40;
  for (unsigned seed = 0; seed < num_seeds; ++seed) {
    const Record known = record(gain, lead_s, 10e-6, 100 + 2 * seed);
    const auto found = dsp::find_common_motion(known.motion, known.segmentation);
    REQUIRE(found);
    CHECK(found->duration_s == Approx(29.0).margin(0.1));  // half a second at either end is left out
    // 10 um of both sensors on 7400 samples of 3.2 mm rms.
    CHECK(found->gain_std == Approx(10e-6 * std::sqrt(2.0) / 3.2e-3 / std::sqrt(7400.0)).epsilon(0.5));
    gains += std::pow((found->gain - gain) / found->gain_std, 2);
    leads += std::pow((found->lead_s - lead_s) / found->lead_std_s, 2);
  }
  // Squares of 40 normal numbers: 1 +- 0.22.
  CHECK(gains / num_seeds == Approx(1.0).margin(0.7));
  CHECK(leads / num_seeds == Approx(1.0).margin(0.7));
}

TEST_CASE("a base brought to the payload's scale and clock leaves no relative motion where there is none",
          "[dsp][common_motion]") {
  Record known = record(1.007, 30e-6, 0.0, 1);
  const auto range = [&] {
    const auto still = known.motion.at("x").segment(static_cast<Index>(25 * rate_hz), static_cast<Index>(20 * rate_hz));
    return still.maxCoeff() - still.minCoeff();
  };
  const double before = range();
  dsp::adopt(known.motion, 1.007, 30e-6);
  CHECK(before > 5e-5);
  CHECK(range() < 2.1e-5);  // the drift of 1 um/s over 20 s
}

TEST_CASE("nothing is said of sensors whose bodies never move as one", "[dsp][common_motion]") {
  Record known = record(1.007, 0.0, 10e-6, 1);
  known.segmentation.segments = {{dsp::Regime::low, 0, known.motion.num_samples()}};
  CHECK_FALSE(dsp::find_common_motion(known.motion, known.segmentation));
}

}  // namespace test_sensors_common_motion
