#include "sim/ode/frequency_response.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/rig/qzs_rig.hpp"

TEST_CASE("the twin unlocks, jumps and locks where it was found to, to a hundredth of a hertz",
          "[sim][frequency_response]") {
  // From where the sweep up is still locked to where the sweep down is on its lower branch.
  const auto parameters = sim::qzs_twin("T0");
  const auto response = sim::frequency_response(parameters, {.from_hz = 0.79, .to_hz = 1.56});
  CHECK(response.jumps.unlock_rising_hz == Approx(1.48).margin(0.0101));
  CHECK(response.jumps.jump_up_falling_hz == Approx(1.49).margin(0.0101));
  CHECK(std::isnan(response.jumps.jump_down_rising_hz));  // damping below the limit: the upper branch has no end
  CHECK(response.jumps.lock_falling_hz == Approx(0.82).margin(0.0101));
  for (const auto& point : response.up)  // amplitudes of the table of the same story, to its last digit
    if (std::abs(point.frequency_hz - 1.50) < 1e-9) {
      CHECK(point.x_m == Approx(26.6e-3).margin(0.06e-3));
      CHECK(point.y_m == Approx(29.7e-3).margin(0.06e-3));
    }
}

TEST_CASE("a locked payload moves with its base", "[sim][frequency_response]") {
  const auto response = sim::frequency_response(sim::qzs_twin("T0"), {.from_hz = 0.5, .to_hz = 0.6, .step_hz = 0.05});
  for (const auto& point : response.up) {
    CHECK(point.locked);
    CHECK(point.x_m == 0.0);
    CHECK(point.y_m == Approx(4.5e-3).epsilon(1e-3));
    CHECK(point.stuck_fraction == 1.0);
  }
  CHECK(std::isnan(response.jumps.unlock_rising_hz));
}

TEST_CASE("without friction and cubic stiffness the response is the linear oscillator's", "[sim][frequency_response]") {
  sim::QzsParameters linear;
  linear.k3 = 0.0;
  linear.mu_kinetic = linear.mu_static = 0.0;
  const auto response =
      sim::frequency_response(linear, {.from_hz = 0.9, .to_hz = 1.5, .step_hz = 0.2, .dwell_s = 60.0});
  for (const auto& point : response.up) {
    const double w = 2.0 * 3.14159265358979323846 * point.frequency_hz;
    const double expected = 4.5e-3 * w * w / std::hypot(linear.k1 - w * w, linear.c * w);
    CHECK(point.x_m == Approx(expected).epsilon(2e-4));  // peaks met by 200 samples a period
    const double lag = std::atan2(linear.c * w, linear.k1 - w * w);
    CHECK(point.phase_rad == Approx(-lag).margin(1e-6));  // what is left of the transient after 60 s
  }
}

TEST_CASE("what happens between two frequencies is classified by locking and by the step in amplitude",
          "[sim][frequency_response]") {
  const auto point = [](double x_m, bool locked) { return sim::ResponsePoint{.x_m = x_m, .locked = locked}; };
  const auto change = [&](double before, double here) {
    return sim::change_between(point(before, before == 0.0), point(here, here == 0.0), 1.4);
  };
  CHECK(change(0.0, 0.0) == sim::SweepChange::none);
  CHECK(change(0.0, 1.0) == sim::SweepChange::unlock);
  CHECK(change(1.0, 0.0) == sim::SweepChange::lock);
  CHECK(change(1.0, 1.39) == sim::SweepChange::none);
  CHECK(change(1.0, 1.41) == sim::SweepChange::jump_up);
  CHECK(change(1.41, 1.0) == sim::SweepChange::jump_down);
  std::vector<sim::ResponsePoint> up{point(0.0, true), point(1.0, false), point(3.0, false), point(2.0, false)};
  for (std::size_t k = 0; k < up.size(); ++k) up[k].frequency_hz = 1.0 + static_cast<double>(k);
  const auto jumps = sim::find_jumps(up, {up.rbegin(), up.rend()}, 1.4);
  CHECK(jumps.unlock_rising_hz == 2.0);
  CHECK(jumps.jump_up_rising_hz == 3.0);
  CHECK(jumps.jump_down_rising_hz == 4.0);
  CHECK(jumps.jump_up_falling_hz == 3.0);
  CHECK(jumps.jump_down_falling_hz == 2.0);
  CHECK(jumps.lock_falling_hz == 1.0);
  CHECK(sim::peak(up).frequency_hz == 3.0);
}

TEST_CASE("frequencies that make no sweep are refused", "[sim][frequency_response]") {
  CHECK_THROWS_AS(sim::frequency_response({}, {.from_hz = 2.0, .to_hz = 1.0}), std::invalid_argument);
  CHECK_THROWS_AS(sim::frequency_response({}, {.step_hz = 0.0}), std::invalid_argument);
}
