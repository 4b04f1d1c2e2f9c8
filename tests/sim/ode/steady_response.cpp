#include "sim/ode/steady_response.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/rig/qzs_rig.hpp"

namespace {

using Drive = sim::DrivenOscillator::Drive;
constexpr double two_pi = 6.283185307179586;

/// The slipping rig with friction at two levels.
sim::DrivenOscillator rig(const sim::QzsParameters& p) {
  return {.acceleration =
              [p](const Drive& r, double x, double v, double sign) {
                return -r[2] - p.c * v - x * (p.k1 + x * (p.k2 + x * p.k3)) - p.mu_kinetic * sign;
              },
          .switches = true,
          .static_friction = p.mu_static};
}

/// q'' = -q - 2 zeta q' - epsilon q^3 + u: driven by a force.
sim::DrivenOscillator duffing(double zeta, double epsilon) {
  return {.acceleration = [=](const Drive& f, double q, double v,
                              double) { return f[0] - 2.0 * zeta * v - q - epsilon * q * q * q; },
          .y_per_drive = 0.0};
}

/// |F| that holds amplitude A at frequency w to first harmonic balance.
double balanced_force(double amplitude, double w, double zeta, double epsilon) {
  return amplitude * std::hypot(1.0 - w * w + 0.75 * epsilon * amplitude * amplitude, 2.0 * zeta * w);
}

}  // namespace

TEST_CASE("the steady response of a linear oscillator is the closed form's", "[sim][steady_response]") {
  sim::QzsParameters linear;
  linear.k3 = 0.0;
  linear.mu_kinetic = linear.mu_static = 0.0;
  const auto found = sim::steady_response(rig(linear), {.from_hz = 0.5, .to_hz = 1.9, .step_hz = 0.2});
  CHECK(found.num_unsettled == 0);
  for (const auto* points : {&found.response.up, &found.response.down})
    for (const auto& point : *points) {
      const double w = two_pi * point.frequency_hz;
      const std::complex<double> x = 4.5e-3 * w * w / std::complex<double>(linear.k1 - w * w, linear.c * w);
      // Runge-Kutta over 64 steps a period: (2 pi / 64)^4 / 120 of the amplitude a radian, over a response time.
      CHECK(point.x_m == Approx(std::abs(x)).epsilon(1e-5));
      CHECK(point.y_m == Approx(std::abs(x + 4.5e-3)).epsilon(1e-5));
      CHECK(point.phase_rad == Approx(std::arg(x)).margin(1e-5));
      CHECK(point.stuck_fraction == 0.0);
    }
  // Steps of 0.2 Hz go up a resonance by a factor of three: steep, but no jump.
  for (const auto jump : {&sim::ResponseJumps::jump_up_rising_hz, &sim::ResponseJumps::jump_down_rising_hz,
                          &sim::ResponseJumps::jump_up_falling_hz, &sim::ResponseJumps::jump_down_falling_hz}) {
    CHECK(std::isnan(found.located.*jump));
    CHECK(std::isnan(found.response.jumps.*jump));
  }
}

TEST_CASE("a weakly damped Duffing oscillator follows harmonic balance, and jumps where it folds",
          "[sim][steady_response]") {
  constexpr double zeta = 0.01, epsilon = 0.04, force = 0.03;
  const auto oscillator = duffing(zeta, epsilon);
  const sim::FrequencyResponseOptions options{
      .from_hz = 0.9 / two_pi, .to_hz = 1.2 / two_pi, .step_hz = 0.005 / two_pi, .amplitude_m = force};
  const auto found = sim::steady_response(oscillator, options);
  for (const auto* points : {&found.response.up, &found.response.down})
    for (const auto& point : *points) {
      // The balance leaves out a third harmonic of epsilon A^2 / 32 (part of the peak) and 3 / 128 epsilon^2 A^4 of
      // stiffness that comes back from it.
      const double a = point.x_m, e = epsilon * a * a;
      const double left_out = a * e * e * (3.0 / 128.0 + 1.5 / 32.0) + force * e / 32.0;
      CHECK(std::abs(balanced_force(a, two_pi * point.frequency_hz, zeta, epsilon) - force) <
            1.5 * left_out + 1e-5 * force);
      CHECK(point.y_m == point.x_m);
    }
  // Folds of the balance: where the force as a function of amplitude has its extremes meet the force given.
  const auto folds = [&](double w) {
    double top = 0.0, bottom = 1e9;  // first maximum, and the minimum behind it
    for (double a = 0.01; a < 2.5; a += 1e-4) {
      const double f = balanced_force(a, w, zeta, epsilon);
      if (f > top && bottom > 1e8)
        top = f;
      else
        bottom = std::min(bottom, f);
    }
    return std::pair(top, bottom);
  };
  double jump_down = 0.0, fall_up = 0.0;  // last w with top < force, last w with bottom < force
  for (double w = 1.02; w < 1.2; w += 2e-4) {
    const auto [top, bottom] = folds(w);
    if (top < force) jump_down = w;
    if (bottom < force) fall_up = w;
  }
  CHECK(two_pi * found.located.jump_up_falling_hz == Approx(jump_down).margin(2e-3));
  CHECK(two_pi * found.located.jump_down_rising_hz == Approx(fall_up).margin(2e-3));
  CHECK(std::isnan(found.located.unlock_rising_hz));
}

TEST_CASE("the periodic motion found by shooting is the one a slow stepped sweep ends in", "[sim][steady_response]") {
  const auto parameters = sim::qzs_twin("T0");
  const sim::FrequencyResponseOptions options{.from_hz = 0.76, .to_hz = 1.56, .step_hz = 0.04};
  const auto swept = sim::frequency_response(parameters, options);
  const auto found = sim::steady_response(rig(parameters), options);
  CHECK(found.num_unsettled == 0);
  for (const auto& [a, b] : {std::pair{&swept.up, &found.response.up}, {&swept.down, &found.response.down}}) {
    REQUIRE(a->size() == b->size());
    for (std::size_t k = 0; k < a->size(); ++k) {
      INFO((*a)[k].frequency_hz << " Hz");
      CHECK((*b)[k].locked == (*a)[k].locked);
      // Peaks met by 200 samples a period, and what is left of the transient after 40 s.
      CHECK((*b)[k].x_m == Approx((*a)[k].x_m).epsilon(3e-4).margin(1e-12));
      CHECK((*b)[k].y_m == Approx((*a)[k].y_m).epsilon(3e-4));
      CHECK((*b)[k].stuck_fraction == Approx((*a)[k].stuck_fraction).margin(0.011));  // 200 samples a period
      if (!(*a)[k].locked) CHECK((*b)[k].phase_rad == Approx((*a)[k].phase_rad).margin(3e-4));
    }
  }
  CHECK(found.response.jumps.unlock_rising_hz == swept.jumps.unlock_rising_hz);
  CHECK(found.response.jumps.jump_up_falling_hz == swept.jumps.jump_up_falling_hz);
  CHECK(found.response.jumps.lock_falling_hz == swept.jumps.lock_falling_hz);
  // At rest only the base's acceleration pulls: it breaks loose where (2 pi f)^2 A passes static friction.
  CHECK(found.located.unlock_rising_hz ==
        Approx(std::sqrt(parameters.mu_static / options.amplitude_m) / two_pi).margin(1.01e-4));
}

TEST_CASE("relative and absolute coordinates give one response", "[sim][steady_response]") {
  const sim::FrequencyResponseOptions options{.from_hz = 0.9, .to_hz = 1.6, .step_hz = 0.1};
  const sim::DrivenOscillator relative{.acceleration = [](const Drive& r, double x, double v, double) {
    return -r[2] - 50.0 * x - 9.5e4 * x * x * x - v;
  }};
  const sim::DrivenOscillator absolute{.acceleration =
                                           [](const Drive& r, double y, double dy, double) {
                                             const double x = y - r[0];
                                             return -50.0 * x - 9.5e4 * x * x * x - (dy - r[1]);
                                           },
                                       .x_per_drive = -1.0,
                                       .y_per_drive = 0.0};
  const auto a = sim::steady_response(relative, options), b = sim::steady_response(absolute, options);
  for (std::size_t k = 0; k < a.response.up.size(); ++k) {
    CHECK(b.response.up[k].x_m == Approx(a.response.up[k].x_m).epsilon(5e-5));  // two discretisations
    CHECK(b.response.up[k].y_m == Approx(a.response.up[k].y_m).epsilon(5e-5));
    CHECK(b.response.up[k].phase_rad == Approx(a.response.up[k].phase_rad).margin(5e-5));
  }
}

TEST_CASE("steps across friction's switches keep the integration's fifth order", "[sim][steady_response]") {
  const auto oscillator = rig(sim::qzs_twin("T0"));
  const auto end = [&](int num_steps) {
    sim::OscillatorState state{.q = 0.02, .v = 0.0, .mode = -1};
    for (int i = 0; i < 3; ++i) state = sim::run_period(oscillator, 1.3, 4.5e-3, state, num_steps).end;
    return state;
  };
  const auto coarse = end(30), fine = end(120), exact = end(1600);
  const double ratio = std::abs(coarse.q - exact.q) / std::abs(fine.q - exact.q);
  CHECK(ratio > 350.0);  // 4^5 in the limit, and 4^4 for an order less
  CHECK(std::abs(coarse.q - exact.q) < 1e-7);
}

TEST_CASE("a motion that runs away ends its sweep, and friction that pushes never holds", "[sim][steady_response]") {
  const sim::DrivenOscillator softening{.acceleration = [](const Drive& r, double x, double v, double) {
    return -r[2] - 50.0 * x + 9.5e4 * x * x * x - v;
  }};
  const auto lost = sim::steady_response(
      softening, {.from_hz = 0.5, .to_hz = 1.5, .step_hz = 0.05, .amplitude_m = 12e-3});  // a crest at 23 mm
  CHECK(lost.diverged_hz > 0.5);
  CHECK(lost.diverged_hz < 1.5);
  CHECK(lost.response.up.size() < 21);

  sim::QzsParameters pushing;
  pushing.mu_kinetic = -0.02;
  pushing.mu_static = 0.0;
  const auto moved = sim::steady_response(rig(pushing), {.from_hz = 0.5, .to_hz = 0.6, .step_hz = 0.05});
  for (const auto& point : moved.response.up) CHECK(!point.locked);
  CHECK_THROWS_AS(sim::steady_response(softening, {.step_hz = 0.0}), std::invalid_argument);
}
