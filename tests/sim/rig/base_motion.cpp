#include "sim/rig/base_motion.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

namespace {

const sim::Programme programmes[] = {sim::stepped_sine_down(),
                                     sim::sine_steps({.frequencies_hz = {1.0, 1.5, 0.7}, .dwell_s = 7.0}),
                                     sim::stepped_sine_up(6e-3, 12.0)};

}  // namespace

TEST_CASE("velocity and acceleration of the base are the derivatives of its displacement", "[sim][base_motion]") {
  for (const auto& programme : programmes) {
    const sim::BaseMotion base(programme);
    // Central differences: error h^2 / 6 times a derivative two orders up, (2 pi 6 Hz)^2 larger at worst.
    const double h = 1e-4;
    double worst_v = 0.0, worst_a = 0.0;
    // Starts, ends and insides of transitions; the second time through as well.
    for (double t = 0.0101; t < 2.2 * programme.duration_s; t += 0.317) {
      const auto before = base.at(t - h), now = base.at(t), after = base.at(t + h);
      worst_v = std::max(worst_v, std::abs((after.r_m - before.r_m) / (2 * h) - now.dr_m_per_s));
      worst_a = std::max(worst_a, std::abs((after.dr_m_per_s - before.dr_m_per_s) / (2 * h) - now.ddr_m_per_s2));
    }
    CHECK(worst_v < 1e-7);
    CHECK(worst_a < 2e-6);
  }
}

TEST_CASE("the base starts from rest and moves on without a jump when its programme starts again",
          "[sim][base_motion]") {
  const sim::BaseMotion base(programmes[1]);
  const auto start = base.at(0.0);
  CHECK(start.r_m == 0.0);
  CHECK(start.ddr_m_per_s2 == 0.0);
  CHECK(base.at(-1.0).r_m == 0.0);
  for (const double t : {21.0, 42.0, 420.0}) {
    const auto before = base.at(t - 1e-9), after = base.at(t + 1e-9);
    CHECK(after.r_m == Approx(before.r_m).margin(1e-10));
    CHECK(after.ddr_m_per_s2 == Approx(before.ddr_m_per_s2).margin(1e-8));
  }
}

TEST_CASE("between transitions the base moves by a pure sine of the asked frequency and amplitude",
          "[sim][base_motion]") {
  const sim::BaseMotion base(programmes[1]);
  for (const auto& [t, f] : {std::pair{5.0, 1.0}, {12.0, 1.5}, {20.0, 0.7}, {33.0, 1.5}}) {
    const auto b = base.at(t);
    const double w = 2 * M_PI * f;
    CHECK(b.ddr_m_per_s2 == Approx(-w * w * b.r_m).epsilon(1e-9));
    CHECK(std::hypot(b.r_m, b.dr_m_per_s / w) == Approx(4.5e-3).epsilon(1e-9));
  }
}

TEST_CASE("the cursor is a matter of speed only", "[sim][base_motion]") {
  const sim::BaseMotion base(programmes[0]);
  for (const double t : {1799.0, 3.0, 1203.7, 40.0, 39.999999, 2400.0}) {
    std::size_t near = 999;
    CHECK(base.at(t, near).r_m == base.at(t).r_m);
  }
}

TEST_CASE("impossible programmes are refused", "[sim][base_motion]") {
  CHECK_THROWS_AS(sim::sine_steps({}), std::invalid_argument);
  CHECK_THROWS_AS(sim::sine_steps({.frequencies_hz = {1.0}, .dwell_s = 2.0}), std::invalid_argument);
  CHECK_THROWS_AS(sim::BaseMotion(sim::Programme{}), std::invalid_argument);
  auto overlapping = programmes[1];
  overlapping.nodes[1].t_s = 1.0;
  CHECK_THROWS_WITH(sim::BaseMotion(overlapping), Catch::Contains("must end by 1 s"));
}

TEST_CASE("a stepped sine settles on its amplitude and frequency by its fourth iteration", "[sim][base_motion]") {
  for (const auto& programme : {sim::stepped_sine_up(3e-3, 20.0), sim::stepped_sine_down(3e-3, 20.0)}) {
    const sim::BaseMotion base(programme);
    for (std::size_t step = 0; 20.0 * static_cast<double>(step) < programme.duration_s; ++step) {
      const auto& node = programme.nodes[4 * step + 3];
      const double end_s = 20.0 * static_cast<double>(step + 1), f = node.frequency_hz;
      double high = 0.0;
      for (double t = end_s - 1.0 / f; t < end_s; t += 1e-3 / f) high = std::max(high, std::abs(base.at(t).r_m));
      // What is left: 4 % and 1.7 % of harmonics, times 0.35^3, and 0.1 % of harmonics that stay.
      CHECK(high == Approx(3e-3).epsilon(0.057 * 0.043 + 0.001));
    }
  }
  CHECK(sim::stepped_sine_down(3e-3, 20.0).manual[0].from_s == 452.5);
  CHECK_THROWS_AS(sim::stepped_sine({.frequencies_hz = {}}), std::invalid_argument);
  CHECK_THROWS_AS(sim::stepped_sine({.frequencies_hz = {1.0}, .dwell_s = 3.0}), std::invalid_argument);
}

TEST_CASE("a hand grips and lets go smoothly, and the base of a free decay is at rest", "[sim][base_motion]") {
  const auto programme = sim::free_decay({.amplitude_m = 20e-3, .dwell_s = 10.0, .num_releases = 3});
  CHECK(programme.duration_s == 30.0);
  REQUIRE(programme.manual.size() == 3);
  CHECK(programme.manual[0].hold_at_m == 20e-3);
  CHECK(programme.manual[1].hold_at_m == -15e-3);
  CHECK(programme.manual[2].hold_at_m == 10e-3);
  const auto& hand = programme.manual[1];
  CHECK(hand.window(hand.from_s) == 0.0);
  CHECK(hand.window(0.5 * (hand.from_s + hand.to_s) + 0.5) == 1.0);
  CHECK(hand.window(hand.to_s - 0.01) == Approx(0.5));
  CHECK(hand.window(hand.to_s) == 0.0);
  const sim::BaseMotion base(programme);
  for (double t = 0.0; t < 70.0; t += 0.37) CHECK(base.at(t).ddr_m_per_s2 == 0.0);
  CHECK_THROWS_AS(sim::free_decay({.num_releases = 0}), std::invalid_argument);
  CHECK_THROWS_AS(sim::free_decay({.dwell_s = 5.0}), std::invalid_argument);
}
