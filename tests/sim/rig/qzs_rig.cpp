#include "sim/rig/qzs_rig.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>

#include "sim/rig/qzs_regimes.hpp"

namespace {

std::shared_ptr<const sim::QzsRig> rig(const sim::QzsParameters& parameters, const sim::Programme& programme) {
  return std::make_shared<const sim::QzsRig>(parameters, programme);
}
const auto t0 = rig(sim::qzs_twin("T0"), sim::stepped_sine_down());

/// Amplitude of x, and fraction of the time it sticks, over the last 10 s of each step.
struct Step {
  double frequency_hz, amplitude_m, stuck;
};
std::vector<Step> steady_steps(const std::vector<double>& frequencies_hz) {
  const auto programme = sim::sine_steps({.frequencies_hz = frequencies_hz});
  sim::QzsTrajectory trajectory(rig({}, programme), programme.duration_s);
  std::vector<Step> steps;
  for (std::size_t k = 0; k < frequencies_hz.size(); ++k) {
    double low = 1.0, high = -1.0, stuck = 0.0;
    for (int n = 0; n < 2000; ++n) {
      const auto& state = trajectory.at(40.0 * static_cast<double>(k) + 30.0 + n / 200.0);
      low = std::min(low, state.x), high = std::max(high, state.x);
      stuck += state.mode == sim::qzs_stick ? 1.0 / 2000 : 0.0;
    }
    steps.push_back({frequencies_hz[k], 0.5 * (high - low), stuck});
  }
  return steps;
}

std::vector<double> grid(double from, double to, double step) {
  std::vector<double> values;
  const int count = static_cast<int>(std::lround((to - from) / step));
  for (int i = 0; i <= std::abs(count); ++i) values.push_back(from + (count < 0 ? -i : i) * std::abs(step));
  return values;
}

}  // namespace

TEST_CASE("the twin's truth has the values two other programs agree on, and its 5655 events", "[sim][qzs_rig]") {
  struct Row {
    double t, x, v, r, ddr;
    int mode;
  };
  const Row rows[] = {{1, 0, 0, 4.874812887e-04, -2.574952149e-02, 0},
                      {10, 6.611005834e-03, 2.461267033e-02, -3.569602868e-03, 4.904502814e-01, 1},
                      {500, 7.310513963e-03, 3.517246593e-02, -3.312318995e-03, 4.043485963e-01, 1},
                      {907, -2.360454497e-02, -3.289351157e-03, 3.091879806e-03, -3.212098826e-01, -1},
                      {950, 2.198936754e-02, -2.093090045e-01, 1.298638154e-04, -7.183350999e-03, -1},
                      {1200, 1.027338216e-02, -5.461124405e-03, -4.130467194e-03, 3.951573026e-01, -1},
                      {1450, 2.344256538e-02, -1.128216463e-02, 2.704000698e-03, -1.932419714e-01, -1},
                      {1719, -2.859895726e-03, -7.420433402e-02, -4.124603349e-03, 1.932615548e-01, -1},
                      {1730, 8.096142111e-03, 0, 2.605527922e-03, -7.664462514e-02, 0},
                      {1790, 5.128414573e-03, 0, -4.172397308e-03, 1.054681818e-01, 0}};
  sim::QzsTrajectory trajectory(t0, 1800.0);
  const double rate = 64.0;
  Eigen::VectorXd x(static_cast<Eigen::Index>(1800 * rate) + 1);
  std::vector<int> modes;
  const Row* row = rows;
  for (Eigen::Index n = 0; n < x.size(); ++n) {
    const auto& state = trajectory.at(static_cast<double>(n) / rate);
    x[n] = state.x;
    modes.push_back(state.mode);
    if (row == std::end(rows) || state.t_s != row->t) continue;
    CAPTURE(row->t);
    CHECK(std::abs(state.x - row->x) < 1e-10);
    CHECK(std::abs(state.v - row->v) < 1e-9);
    CHECK(std::abs(state.base.r_m - row->r) < 1e-12);
    CHECK(std::abs(state.base.ddr_m_per_s2 - row->ddr) < 1e-10);
    CHECK(state.mode == row->mode);
    ++row;
  }
  CHECK(row == std::end(rows));
  CHECK(trajectory.events().size() == 5655);

  const auto regimes = sim::true_regimes(t0, x, modes, rate);
  // At 1406.4 s the phase passes quadrature, six seconds after the lower branch ended; at 1722.5 s it sticks first.
  const std::pair<const char*, double> expected[] = {{"stick", 1.9},  {"low", 907.7},   {"high", 981.2},
                                                     {"low", 1406.4}, {"high", 1722.5}, {"stick", 1800.0}};
  REQUIRE(regimes.size() == std::size(expected));
  for (std::size_t i = 0; i < regimes.size(); ++i) {
    CHECK(regimes[i].label == expected[i].first);
    CHECK(regimes[i].to_s == Approx(expected[i].second).margin(0.1));
  }
}

TEST_CASE("a payload let go on a linear spring loses 2 mu / k1 of amplitude with every half swing", "[sim][qzs_rig]") {
  const sim::QzsParameters parameters{.k3 = 0.0, .c = 0.0, .mu_kinetic = 0.08, .mu_static = 0.08};
  const auto decay = rig(parameters, sim::free_decay({.amplitude_m = 20e-3, .dwell_s = 20.0, .num_releases = 2}));
  sim::QzsTrajectory trajectory(decay, 39.0);
  const double half_swing_s = M_PI / std::sqrt(50.0), loss = 2.0 * 0.08 / 50.0;
  for (const auto& hand : decay->programme().manual) {
    const double released = trajectory.at(hand.to_s - hand.release_s).x;
    CHECK(released == Approx(hand.hold_at_m).epsilon(0.03));  // the hand gives by k1 / stiffness
    // Letting go takes 20 ms of a swing of 440: the first turning point is known to a per cent only, the rest exactly.
    double last = 0.0;
    for (int swing = 1; swing * loss + 0.08 / 50.0 < std::abs(released); ++swing) {
      double turn = 0.0;  // the largest excursion around the time where the swing ends
      for (double t = hand.to_s + (swing - 0.3) * half_swing_s; t < hand.to_s + (swing + 0.3) * half_swing_s; t += 1e-4)
        turn = std::max(turn, std::abs(trajectory.at(t).x));
      if (swing == 1) CHECK(turn == Approx(std::abs(released) - loss).epsilon(0.01));
      if (swing > 1) CHECK(last - turn == Approx(loss).margin(1e-7));
      last = turn;
    }
    const auto& rest = trajectory.at(hand.to_s + 14.0);
    CHECK(rest.mode == sim::qzs_stick);
    CHECK(std::abs(rest.x) <= 0.08 / 50.0);
  }
}

TEST_CASE("between nodes the trajectory obeys its own equation of motion", "[sim][qzs_rig]") {
  for (const auto* twin : {"T0", "T1"}) {
    sim::QzsTrajectory trajectory(rig(sim::qzs_twin(twin), sim::stepped_sine_down()), 60.0);
    // Second differences of x over 1/2560 s: rounding 4 eps x / h^2 = 6e-11, error h^2 / 12 x'''' = 1e-8 * 1e3 ... and
    // across an event they mean nothing.
    const double h = 1.0 / 2560.0;
    sim::QzsState last[2];
    double worst_v = 0.0, worst_a = 0.0;
    for (int n = 0; n <= 60 * 2560; ++n) {
      const auto state = trajectory.at(n * h);
      if (n > 1 && state.mode == last[1].mode && last[0].mode == state.mode && std::abs(last[0].v) > 0.02) {
        worst_v = std::max(worst_v, std::abs((state.x - last[1].x) / (2 * h) - last[0].v));
        worst_a = std::max(worst_a, std::abs((state.v - last[1].v) / (2 * h) - last[0].a));
      }
      last[1] = last[0];
      last[0] = state;
    }
    INFO(twin);
    CHECK(worst_v < 2e-6);
    CHECK(worst_a < 1e-3);
  }
}

TEST_CASE("the rig's state at a time does not depend on the times asked for before", "[sim][qzs_rig]") {
  sim::QzsTrajectory coarse(t0, 10.0), fine(t0, 10.0);
  for (int n = 1; n <= 2000; ++n) {
    const double t = n / 200.0;
    (void)fine.at(t - 0.003);
    const auto expected = coarse.at(t), state = fine.at(t);
    REQUIRE(state.x == expected.x);
    REQUIRE(state.a == expected.a);
  }
  CHECK_THROWS_AS(coarse.at(9.0), std::invalid_argument);
  CHECK_THROWS_AS(coarse.at(0.0), std::invalid_argument);
  CHECK_THROWS_AS(coarse.at(10.1), std::invalid_argument);
}

TEST_CASE("while it sticks less than static friction pulls, and a slip starts from rest", "[sim][qzs_rig]") {
  const auto programme = sim::sine_steps({.frequencies_hz = {0.85}});
  const auto slow = rig({}, programme);
  // Pushed off its lock by starting fast.
  const auto fast = rig({}, sim::sine_steps({.frequencies_hz = {1.6, 0.85}}));
  sim::QzsTrajectory locked(slow, 40.0), slipping(fast, 80.0);
  for (int n = 0; n < 4000; ++n) REQUIRE(locked.at(n / 100.0).mode == sim::qzs_stick);
  int stuck = 0, slipped = 0;
  for (int n = 0; n < 16000; ++n) {
    const auto& s = slipping.at(n / 200.0);
    if (s.mode == sim::qzs_stick) {
      ++stuck;
      const double pull = -s.base.ddr_m_per_s2 - 50.0 * s.x - 9.5e4 * s.x * s.x * s.x;
      REQUIRE(std::abs(pull) <= 0.385 + 1e-8);
      REQUIRE(s.v == 0.0);
      REQUIRE(s.a == 0.0);
    } else {
      ++slipped;
      REQUIRE(s.v * s.mode >= -1e-8);
    }
  }
  CHECK(stuck > 100);
  CHECK(slipped > 8000);
}

TEST_CASE("swept up it breaks loose at 1.48 Hz", "[sim][qzs_rig]") {
  const auto steps = steady_steps(grid(1.44, 1.50, 0.01));
  for (const auto& step : steps) {
    CAPTURE(step.frequency_hz);
    if (step.frequency_hz < 1.475)
      CHECK(step.amplitude_m == 0.0);
    else
      CHECK(step.amplitude_m == Approx(0.02589 + (step.frequency_hz - 1.48) * 0.035).margin(1e-4));
  }
}

TEST_CASE("swept down it jumps up at 1.49 Hz and locks at 0.82 Hz", "[sim][qzs_rig]") {
  for (const auto& step : steady_steps(grid(1.60, 1.47, -0.01))) {
    CAPTURE(step.frequency_hz);
    CHECK((step.amplitude_m > 0.02) == (step.frequency_hz < 1.495));
    if (std::abs(step.frequency_hz - 1.60) < 1e-6) CHECK(step.amplitude_m == Approx(9.29e-3).epsilon(2e-3));
    if (std::abs(step.frequency_hz - 1.50) < 1e-6) CHECK(step.amplitude_m == Approx(12.59e-3).epsilon(2e-3));
    if (std::abs(step.frequency_hz - 1.49) < 1e-6) CHECK(step.amplitude_m == Approx(26.22e-3).epsilon(2e-3));
  }
  auto down = grid(1.45, 0.90, -0.05);
  const auto last = grid(0.89, 0.80, -0.01);
  down.insert(down.end(), last.begin(), last.end());
  for (const auto& step : steady_steps(down)) {
    CAPTURE(step.frequency_hz);
    CHECK((step.stuck == 1.0) == (step.frequency_hz < 0.825));
    if (std::abs(step.frequency_hz - 1.0) < 1e-6) CHECK(step.amplitude_m == Approx(8.58e-3).epsilon(2e-3));
  }
}

TEST_CASE("a free decay dies out and sticks", "[sim][qzs_rig]") {
  // A programme of another kind: strong shaking that is switched off.
  sim::Programme decay{.name = "decay",
                       .nodes = {{0.0, 3.0, 1.7, {4.5e-3, 0.0, 0.0}}, {20.0, 0.3, 1.7, {}}},
                       .manual = {},
                       .duration_s = 40.0};
  sim::QzsTrajectory trajectory(rig({}, decay), 40.0);
  CHECK(std::abs(trajectory.at(19.9).base.ddr_m_per_s2) + std::abs(trajectory.at(20.0).base.ddr_m_per_s2) > 0.1);
  const auto& end = trajectory.at(40.0);
  CHECK(end.mode == sim::qzs_stick);
  CHECK(end.base.r_m == 0.0);
  CHECK(std::abs(50.0 * end.x + 9.5e4 * end.x * end.x * end.x) <= 0.385);
}

TEST_CASE("a twin's parameters are found and set by name", "[sim][qzs_rig]") {
  auto parameters = sim::qzs_twin("T1");
  CHECK(parameters.k2 == -200.0);
  sim::set_parameter(parameters, "mu_static", 0.5);
  CHECK(parameters.mu_static == 0.5);
  CHECK_THROWS_WITH(sim::set_parameter(parameters, "mass", 1.0), Catch::Contains("mu_kinetic, mu_static"));
  CHECK_THROWS_WITH(sim::qzs_twin("T2"), Catch::Contains("T0, T1"));
  parameters.mu_kinetic = 0.6;
  CHECK_THROWS_WITH(sim::QzsRig(parameters, sim::stepped_sine_down()), Catch::Contains("mu_kinetic <= mu_static"));
  parameters = sim::qzs_twin("T1");
  parameters.time_modulation = -1.0;
  CHECK_THROWS_WITH(sim::QzsRig(parameters, sim::stepped_sine_down()), Catch::Contains("|time_modulation| < 1"));
  const auto terms = sim::true_terms(sim::qzs_twin("T0"));
  CHECK(std::any_of(terms.begin(), terms.end(), [](const auto& t) { return t.name == "x^3" && t.value == -9.5e4; }));
}
