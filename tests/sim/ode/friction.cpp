#include "sim/ode/friction.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "sim/simulate.hpp"

TEST_CASE("motion goes where one side leads away, and rests where none does", "[sim][friction]") {
  CHECK(sim::side_from_zero({.above = -1.0, .below = 2.0}, 1) == 0);
  CHECK(sim::side_from_zero({.above = 0.0, .below = 1.0}, 1) == 0);  // pulled with just what friction holds
  CHECK(sim::side_from_zero({.above = 1.0, .below = 2.0}, 1) == 1);
  CHECK(sim::side_from_zero({.above = -2.0, .below = -1.0}, 1) == -1);
  for (const int before : {-1, 1}) CHECK(sim::side_from_zero({.above = 1.0, .below = -1.0}, before) == -before);
}

TEST_CASE("each combination of sides is a mode of its own", "[sim][friction]") {
  std::set<std::array<double, 3>> seen;
  for (int mode = -13; mode <= 13; ++mode) {
    std::array<double, 3> sides{};
    sim::sides_of(mode, 3, sides.data());
    CHECK(sides[0] + 3.0 * sides[1] + 9.0 * sides[2] == mode);
    seen.insert(sides);
  }
  CHECK(seen.size() == 27);
  double side = 0.0;
  sim::sides_of(-1, 1, &side);
  CHECK(side == -1.0);
}

TEST_CASE("more switches than can be followed are refused", "[sim][friction]") {
  sim::System system;
  CHECK_THROWS_AS(sim::add_switches(system, {.count = sim::max_switches + 1}), std::invalid_argument);
}

TEST_CASE("a slider on a pull that grows breaks loose where it passes the friction", "[sim][friction]") {
  sim::System system{.name = "slider", .states = {"x", "v"}, .rhs = [](double t, const double* y, int mode, double* d) {
                       d[0] = y[1];
                       d[1] = mode == 0 ? 0.0 : t - 2.0 * mode;
                     }};
  sim::add_switches(system, sim::velocity_switch([](double t, const double*) {
                      return sim::RatesAtZero{t - 2.0, t + 2.0};
                    }));
  const auto run = sim::simulate(system, Eigen::Vector2d::Zero(), {.duration_s = 4.0, .sample_rate_hz = 1.0});
  REQUIRE(run.events.size() == 1);
  CHECK(run.events[0].t_s == Approx(2.0).margin(1e-9));
  CHECK(run.states(2, 1) == 0.0);
  CHECK(run.states(4, 1) == Approx(2.0).margin(1e-8));  // (4 - 2)^2 / 2
}
