#include "sim/systems.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <map>

#include "sim/ode/friction.hpp"
#include "sim/simulate.hpp"

namespace {

sim::Simulation run(const sim::Experiment& e, double duration_s = 25.0, double sample_rate_hz = 100.0) {
  auto result = sim::simulate(e.system, e.initial, {.duration_s = duration_s, .sample_rate_hz = sample_rate_hz});
  REQUIRE(result.status == sim::SimulationStatus::finished);
  return result;
}

double sgn(double value) {
  return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0;
}

/// The candidate terms of the truths, written out by hand.
using TermFunction = double (*)(double x, double v, double z, double f);
const std::map<std::string, TermFunction> terms = {
    {"x", [](double x, double, double, double) { return x; }},
    {"v", [](double, double v, double, double) { return v; }},
    {"z", [](double, double, double z, double) { return z; }},
    {"f", [](double, double, double, double f) { return f; }},
    {"x^3", [](double x, double, double, double) { return x * x * x; }},
    {"sgn(v)", [](double, double v, double, double) { return sgn(v); }},
    {"z*abs(v)", [](double, double v, double z, double) { return z * std::abs(v); }},
    {"abs(v)*z", [](double, double v, double z, double) { return z * std::abs(v); }},
    {"abs(z)*v", [](double, double v, double z, double) { return std::abs(z) * v; }},
    {"z*abs(z)^0.5*abs(v)",
     [](double, double v, double z, double) { return z * std::sqrt(std::abs(z)) * std::abs(v); }},
    {"abs(z)^1.5*v", [](double, double v, double z, double) { return std::pow(std::abs(z), 1.5) * v; }},
    {"abs(v)*x", [](double x, double v, double, double) { return std::abs(v) * x; }},
    {"x^2*v^2", [](double x, double v, double, double) { return x * x * v * v; }},
    {"exp(x)*v*abs(v)", [](double x, double v, double, double) { return std::exp(x) * v * std::abs(v); }},
    {"v*sin(x)", [](double x, double v, double, double) { return v * std::sin(x); }},
    {"x*v", [](double x, double v, double, double) { return x * v; }},
    {"v*z", [](double, double v, double z, double) { return v * z; }},
};

/// Largest difference between the simulated derivatives and the truth in candidate terms, relative to each row's size.
double truth_residual(const sim::Experiment& e) {
  const auto result = run(e);
  const auto num_states = result.states.cols();
  Eigen::VectorXd worst = Eigen::VectorXd::Zero(num_states);
  for (Eigen::Index n = 0; n < result.states.rows(); ++n) {
    const double x = result.states(n, 0), v = result.states(n, 1), z = num_states == 3 ? result.states(n, 2) : 0.0;
    if (v == 0.0) continue;  // on a switch sgn(v) is 0, while the motion already follows one side
    const double f = e.system.forcing(result.time_s[n]);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(num_states);
    for (const auto& term : e.truth)
      if (term.where.empty() || (term.where == "v >= 0") == (v >= 0.0))
        sum[term.row - 1] += term.value * terms.at(term.name)(x, v, z, f);
    worst = worst.cwiseMax((sum - result.derivatives.row(n).transpose()).cwiseAbs());
  }
  return (worst.array() / result.derivatives.cwiseAbs().colwise().maxCoeff().transpose().array()).maxCoeff();
}

}  // namespace

TEST_CASE("the truth in candidate terms is what was integrated, for every system", "[sim][systems]") {
  for (const auto& name : sim::experiment_names()) {
    INFO(name);
    // Rounding of the sums, no more: the terms cancel at most a thousandfold.
    CHECK(truth_residual(sim::make_experiment(name)) < 1e-12);
  }
  CHECK(truth_residual(sim::make_experiment(sim::BoucWen{.a = 0.3, .alpha = 1.5, .delta = 0.02, .gamma = 0.01})) <
        1e-12);
}

TEST_CASE("the linear oscillator follows its exact forced response", "[sim][systems]") {
  const sim::Linear p{.zeta = 0.05, .ratio = 0.8, .x0 = 0.3, .v0 = -1.0};
  const auto result = run(sim::make_experiment(p));
  // Steady part Re(X e^{i w t}) plus a free decay that meets the initial conditions.
  const std::complex<double> i(0.0, 1.0);
  const double w = p.ratio * p.omega_n, decay = p.zeta * p.omega_n, wd = p.omega_n * std::sqrt(1 - p.zeta * p.zeta);
  const std::complex<double> steady = p.force_n / (p.omega_n * p.omega_n - w * w + 2.0 * i * decay * w);
  const double a = p.x0 - steady.real(), b = (p.v0 - (i * w * steady).real() + decay * a) / wd;
  double worst = 0.0;
  for (Eigen::Index n = 0; n < result.time_s.size(); ++n) {
    const double t = result.time_s[n];
    const double x =
        (steady * std::exp(i * w * t)).real() + std::exp(-decay * t) * (a * std::cos(wd * t) + b * std::sin(wd * t));
    worst = std::max(worst, std::abs(result.states(n, 0) - x));
  }
  CHECK(worst < 1e-7);  // of an amplitude of 10 m
}

TEST_CASE("Duffing agrees with fixed-step Runge-Kutta", "[sim][systems]") {
  const sim::Duffing p{.ratio = 1.3};
  const auto result = run(sim::make_experiment(p), 10.0);
  const auto acceleration = [&](double t, double x, double v) {
    return 100.0 * std::cos(6.5 * t) - v - 25.0 * x - 2500.0 * x * x * x;
  };
  double x = 0.0, v = 0.0, worst = 0.0;
  const int steps_per_sample = 40;
  const double h = 0.01 / steps_per_sample;
  for (int n = 0; n < 1000 * steps_per_sample; ++n) {
    if (n % steps_per_sample == 0) worst = std::max(worst, std::abs(x - result.states(n / steps_per_sample, 0)));
    const double t = n * h;
    const double k1 = v, l1 = acceleration(t, x, v);
    const double k2 = v + h / 2 * l1, l2 = acceleration(t + h / 2, x + h / 2 * k1, k2);
    const double k3 = v + h / 2 * l2, l3 = acceleration(t + h / 2, x + h / 2 * k2, k3);
    const double k4 = v + h * l3, l4 = acceleration(t + h, x + h * k3, k4);
    x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    v += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
  }
  // Both are good to about 1e-9; the flow stretches errors some tenfold over 10 s.
  CHECK(worst < 1e-7);
}

TEST_CASE("Coulomb friction takes 4 F / k of amplitude a cycle and then holds the mass", "[sim][systems]") {
  const sim::Coulomb p{.c = 0.0, .c_f = 1.0, .force_n = 0.0, .x0 = 0.0113};
  const auto result = run(sim::make_experiment(p), 2.0, 1000.0);
  const double loss = 2.0 * p.c_f / p.k, half_period = M_PI / std::sqrt(p.k / p.m);
  REQUIRE(result.events.size() == 6);  // 11.3 9.3 7.3 5.3 3.3 1.3 -0.7 mm: held inside F / k = 1 mm
  for (std::size_t n = 0; n < result.events.size(); ++n)
    CHECK(result.events[n].t_s == Approx(static_cast<double>(n + 1) * half_period).epsilon(1e-8));
  CHECK(result.events.back().mode_after == 0);
  CHECK(result.states(2000, 0) == Approx(p.x0 - 6 * loss).margin(1e-10));
  CHECK(result.states(2000, 1) == 0.0);
  CHECK(result.derivatives(2000, 1) == 0.0);
}

TEST_CASE("a Coulomb slider stays put under less force than friction and moves under more", "[sim][systems]") {
  const auto held = run(sim::make_experiment(sim::Coulomb{.force_n = 0.99}));
  CHECK(held.events.empty());
  CHECK(held.states.cwiseAbs().maxCoeff() == 0.0);
  const auto moved = run(sim::make_experiment(sim::Coulomb{.force_n = 3.0, .ratio = 0.1}));
  CHECK(moved.states.col(0).maxCoeff() > 1e-3);
  // Slow forcing: it stops and starts every half period, and where it sticks the force balance allows it.
  CHECK(std::count(moved.modes.begin(), moved.modes.end(), 0) > 500);
  double worst = 0.0;
  for (Eigen::Index n = 0; n < moved.time_s.size(); ++n)
    if (moved.modes[static_cast<std::size_t>(n)] == 0)
      worst = std::max(
          worst, std::abs(3.0 * std::cos(0.1 * std::sqrt(1000.0) * moved.time_s[n]) - 1000.0 * moved.states(n, 0)));
  CHECK(worst <= 1.0 + 1e-9);
}

TEST_CASE("the seven records of the Coulomb case have their 1763 reversals at any tolerance", "[sim][systems]") {
  // As many by ARKODE, CVODE and scipy with events. None sticks, so each is a change from one side to the other.
  for (const double tolerance : {1e-6, 1e-8, 1e-10}) {
    std::size_t count = 0;
    for (const double ratio : {0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3}) {
      const auto e = sim::make_experiment("coulomb", {{"ratio", ratio}});
      const auto result = sim::simulate(e.system, e.initial,
                                        {.duration_s = 25.0,
                                         .sample_rate_hz = 100.0,
                                         .relative_tolerance = tolerance,
                                         .absolute_tolerance = 0.01 * tolerance});
      count += result.events.size();
      CHECK(std::all_of(result.events.begin(), result.events.end(),
                        [](const sim::Event& event) { return event.mode_after == -event.mode_before; }));
    }
    CHECK(count == 1763);
  }
}

TEST_CASE("the energy put into a Coulomb slider is stored or lost to friction and damping", "[sim][systems]") {
  const sim::Coulomb p{.ratio = 0.7};
  const auto e = sim::make_experiment(p);
  const double rate = 20000.0;
  const auto result = run(e, 5.0, rate);
  const auto power = [&](Eigen::Index n) {
    const double v = result.states(n, 1);
    return p.force_n * e.system.forcing(result.time_s[n]) * v - p.c * v * v - p.c_f * std::abs(v);
  };
  double work = 0.0, scale = 0.0;
  for (Eigen::Index n = 1; n < result.time_s.size(); ++n) {
    work += 0.5 * (power(n - 1) + power(n)) / rate;
    scale += std::abs(power(n)) / rate;
  }
  const auto energy = [&](Eigen::Index n) {
    return 0.5 * (p.m * std::pow(result.states(n, 1), 2) + p.k * std::pow(result.states(n, 0), 2));
  };
  // The trapezoidal rule errs by (omega h)^2 / 12 of the work, omega the highest frequency of note (100 rad/s).
  CHECK(std::abs(energy(result.time_s.size() - 1) - energy(0) - work) < 2.1e-6 * scale);
}

TEST_CASE("Bouc-Wen loads along its exponential and saturates at k (delta + gamma)^(-1/alpha)", "[sim][systems]") {
  const sim::BoucWen p;
  const auto result = run(sim::make_experiment(p));
  const double limit = p.k / (p.delta + p.gamma);
  Eigen::Index n = 0;
  double worst = 0.0;
  for (; result.states(n, 1) >= 0.0; ++n) {
    const double loaded = limit * -std::expm1(-(p.delta + p.gamma) * result.states(n, 0));
    worst = std::max(worst, std::abs(result.states(n, 2) - loaded));
  }
  REQUIRE(n > 20);
  CHECK(worst < 1e-7);
  CHECK(result.states.col(2).cwiseAbs().maxCoeff() <= limit);
  CHECK(result.states.col(2).cwiseAbs().maxCoeff() > 0.99 * limit);
  const auto sharp = run(sim::make_experiment(sim::BoucWen{.alpha = 2.0, .delta = 2.0, .gamma = 2.0}));
  CHECK(sharp.states.col(2).cwiseAbs().maxCoeff() == Approx(25.0).epsilon(1e-3));
}

TEST_CASE("Valanis I and IV load along the solution of their first-order equation in x", "[sim][systems]") {
  // dF/dx = e1 + alpha g(x) - e2 F from F(0) = 0 while v > 0, with g = x or sin x.
  const sim::Valanis1 one;
  const auto first = run(sim::make_experiment(one));
  const sim::Valanis4 four;
  const auto fourth = run(sim::make_experiment(four));
  double worst = 0.0;
  Eigen::Index n = 1;
  for (; first.states(n, 1) >= 0.0 && fourth.states(n, 1) >= 0.0; ++n) {
    double x = first.states(n, 0), q = one.e2;
    const double f1 = (one.e1 / q - one.alpha / (q * q)) * -std::expm1(-q * x) + one.alpha / q * x;
    worst = std::max(worst, std::abs(first.states(n, 2) - f1));
    x = fourth.states(n, 0), q = four.e2;
    const double f4 = four.e1 / q * -std::expm1(-q * x) +
                      four.alpha1 / (1 + q * q) * (q * std::sin(x) - std::cos(x) + std::exp(-q * x));
    worst = std::max(worst, std::abs(fourth.states(n, 2) - f4));
  }
  REQUIRE(n > 10);
  CHECK(worst < 1e-9);
}

TEST_CASE("every reversal of a hysteretic system is an event", "[sim][systems]") {
  for (const auto* name : {"bouc-wen", "valanis-1", "valanis-2", "valanis-3", "valanis-4"}) {
    INFO(name);
    const auto result = run(sim::make_experiment(name));
    int reversals = 0;
    for (Eigen::Index n = 2; n < result.states.rows(); ++n)
      reversals += result.states(n, 1) * result.states(n - 1, 1) < 0.0;
    CHECK(std::count_if(result.events.begin(), result.events.end(),
                        [](const auto& event) { return event.which == 0; }) == reversals);
    for (Eigen::Index n = 0; n < result.states.rows(); ++n)
      if (result.states(n, 1) != 0.0) {
        double side = 0.0;
        sim::sides_of(result.modes[static_cast<std::size_t>(n)], 1, &side);
        REQUIRE(side * result.states(n, 1) > 0.0);
      }
  }
}

TEST_CASE("parameters are set by name and unknown ones are refused with the list", "[sim][systems]") {
  const auto e = sim::make_experiment("duffing", {{"epsilon", 2.0}, {"x0", 0.5}});
  CHECK(e.initial[0] == 0.5);
  CHECK(e.truth.back().value == -50.0);
  CHECK_THROWS_WITH(sim::make_experiment("duffing", {{"mass", 2.0}}), Catch::Contains("epsilon, force_n, ratio"));
  CHECK_THROWS_WITH(sim::make_experiment("pendulum"), Catch::Contains("valanis-4"));
}
