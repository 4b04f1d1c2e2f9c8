#include "dsp/reversals.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "support/signals.hpp"

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 256.0;

struct Course {
  VectorXd v, a;
};

// Half sines of v at 1.25 Hz to and fro, `halt_s` of rest after each; friction lowers the acceleration by `drop` m/s^2
// over the first half of each, as it does at a reversal. a is exact but for noise, and as steep.
Course course(double halt_s, double drop, double noise, unsigned seed) {
  const double half_s = 0.4, amplitude = 0.05, omega = std::numbers::pi / half_s;
  const auto n = static_cast<Index>(60.0 * rate_hz);
  Course result{VectorXd::Zero(n), support::gaussian(n, seed, noise)};
  for (Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / rate_hz, number = std::floor(t / (half_s + halt_s)),
                 in_it = t - number * (half_s + halt_s), sign = std::fmod(number, 2.0) == 0.0 ? 1.0 : -1.0;
    if (in_it >= half_s) {
      result.v(i) = 1e-9 * sign;  // a halt: it turns when it ends
      continue;
    }
    const double slower = in_it < half_s / 2 ? in_it : half_s - in_it;
    result.v(i) = sign * (amplitude * std::sin(omega * in_it) - drop * slower);
    result.a(i) += sign * (amplitude * omega * std::cos(omega * in_it) - (in_it < half_s / 2 ? drop : -drop));
  }
  return result;
}

std::vector<dsp::Reversal> reversals(const Course& c, double halt_s) {
  return dsp::reversals(c.v, c.a, static_cast<Index>(2.0 * (0.4 + halt_s) * rate_hz));
}

}  // namespace

TEST_CASE("a halt takes the acceleration away, a plain reversal does not", "[dsp][reversals]") {
  for (const double noise : {0.0, 0.005, 0.02}) {
    INFO("noise " << noise);
    const auto plain = reversals(course(0.0, 0.1, noise, 11), 0.0);
    REQUIRE(plain.size() > 140);
    const double bar = dsp::halting_share(plain);
    CHECK(bar > 0.5);
    for (const auto& r : plain) CHECK_FALSE(dsp::is_halt(r, bar));
    for (const double halt_s : {0.012, 0.02, 0.04}) {
      const auto halting = reversals(course(halt_s, 0.1, noise, 12), halt_s);
      REQUIRE(halting.size() > 130);
      for (const auto& r : halting) CHECK(r.acceleration_share < 0.4);
      for (const auto& r : halting) CHECK(dsp::is_halt(r, bar));
    }
  }
}

TEST_CASE("a shallow dip is a halt only if it has edges", "[dsp][reversals]") {
  // Dips at every tenth reversal, of 12 ms and of 120 ms; either takes less than half of three samples' mean.
  const auto halts_seen = [](double half_width_s, double depth) {
    Course c = course(0.0, 0.0, 0.002, 14);
    for (Index i = 0; i < c.a.size(); ++i) {
      const double t = static_cast<double>(i) / rate_hz, number = std::round(t / 0.4), away_s = t - 0.4 * number;
      if (static_cast<int>(number) % 10 == 0 && std::abs(away_s) < half_width_s)
        c.a(i) *= 1.0 - 0.5 * depth * (1.0 + std::cos(std::numbers::pi * away_s / half_width_s));
    }
    const auto all = reversals(c, 0.0);
    const double bar = dsp::halting_share(all);
    return std::count_if(all.begin(), all.end(), [&](const auto& r) { return dsp::is_halt(r, bar); });
  };
  CHECK(halts_seen(0.006, 0.8) == 14);
  CHECK(halts_seen(0.060, 0.4) == 0);
}

TEST_CASE("reversals nobody can tell are left out", "[dsp][reversals]") {
  const auto noisy = course(0.0, 0.1, 0.5, 13);
  CHECK(reversals(noisy, 0.0).empty());
  CHECK(dsp::reversals(VectorXd::Ones(500), VectorXd::Zero(500), 100).empty());
  CHECK(dsp::halting_share({}) == 0.0);
}
