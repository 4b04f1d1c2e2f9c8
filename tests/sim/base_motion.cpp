#include "sim/base_motion.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

namespace {

const sim::Programme programmes[] = {sim::stepped_sine_down(),
                                     sim::sine_steps({.frequencies_hz = {1.0, 1.5, 0.7}, .dwell_s = 7.0})};

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
