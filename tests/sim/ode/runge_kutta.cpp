#include "sim/ode/runge_kutta.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/ode/dormand_prince.hpp"
#include "sim/ode/zero_of.hpp"

namespace {

/// y' = y cos t, y = e^(sin t), beside an oscillator of its own: every kind of tree of the order conditions takes part.
const auto rhs = [](double t, const double* y, double* dydt) {
  dydt[0] = y[0] * std::cos(t);
  dydt[1] = -y[2] * y[0];
  dydt[2] = y[1] * y[0];
};

using Vector = Eigen::Vector3d;

/// State at t, from equal steps that end there, the last one looked at `u` of its length.
template <class Formula>
Vector integrated(double t, int num_steps, double u) {
  sim::RungeKutta<Formula, 3> formula(3);
  const double h = t / (num_steps - 1 + u);
  formula.start(rhs, 0.0, Vector(1.0, 1.0, 0.0));
  for (int i = 0; i < num_steps; ++i) {
    if (i > 0) formula.go_on();
    formula.step(rhs, h);
  }
  Vector y;
  formula.between(rhs, u, y.data());
  return y;
}

/// By how many powers of two the error falls when steps are halved.
template <class Formula>
double order_seen(int num_steps, double u) {
  const double t = 3.0;
  const Vector exact = integrated<Formula>(t, 60 * num_steps, 1.0);
  const double coarse = (integrated<Formula>(t, num_steps, u) - exact).norm(),
               fine = (integrated<Formula>(t, 2 * num_steps, u) - exact).norm();
  return std::log2(coarse / fine);
}

template <class Formula>
void check_row_sums() {
  for (std::size_t i = 0; i < Formula::num_slopes; ++i) {
    double sum = 0.0;
    for (std::size_t j = 0; j < Formula::num_slopes; ++j) sum += Formula::a[i][j];
    CHECK(sum == Approx(Formula::c[i]).margin(1e-14));  // rounding of sixteen coefficients of up to 50
  }
  for (const auto& row : Formula::error) {
    double sum = 0.0;
    for (const double weight : row) sum += weight;
    CHECK(sum == Approx(0.0).margin(1e-14));
  }
}

}  // namespace

TEST_CASE("every stage lies where it says, and a constant slope has no error", "[sim][runge_kutta]") {
  check_row_sums<sim::DormandPrince5>();
  check_row_sums<sim::DormandPrince8>();
}

TEST_CASE("halved steps err less by the order of the formula", "[sim][runge_kutta]") {
  // Steps at which the next order adds less than a third of a power.
  CHECK(order_seen<sim::DormandPrince5>(40, 1.0) == Approx(5.0).margin(0.35));
  CHECK(order_seen<sim::DormandPrince8>(8, 1.0) == Approx(8.0).margin(0.5));
}

TEST_CASE("between the ends of a step the solution is of the order below", "[sim][runge_kutta]") {
  // A polynomial of degree p errs by h^(p+1) once, at the end of a solution that errs by h^q: 5 and 5, 8 and 8.
  for (const double u : {0.3, 0.5, 0.8}) {
    CHECK(order_seen<sim::DormandPrince5>(80, u) > 4.5);
    CHECK(order_seen<sim::DormandPrince8>(12, u) > 7.3);
  }
}

TEST_CASE("the polynomial of a step joins its ends in value and slope", "[sim][runge_kutta]") {
  const auto check = [](auto formula) {
    formula.start(rhs, 0.2, Vector(1.0, 0.5, -0.3));
    formula.step(rhs, 0.05);
    Vector low, low_next, high, high_before, slope;
    const double d = 1e-6;
    formula.between(rhs, 0.0, low.data());
    formula.between(rhs, d, low_next.data());
    formula.between(rhs, 1.0 - d, high_before.data());
    formula.between(rhs, 1.0, high.data());
    CHECK((low - formula.begin()).norm() == 0.0);
    CHECK((high - formula.end()).norm() < 1e-15);
    // A one-sided difference errs by half a second derivative times d h, and by rounding over d h.
    rhs(0.2, low.data(), slope.data());
    CHECK(((low_next - low) / (d * 0.05) - slope).norm() < 1e-7);
    rhs(0.25, high.data(), slope.data());
    CHECK(((high - high_before) / (d * 0.05) - slope).norm() < 1e-7);
  };
  check(sim::RungeKutta<sim::DormandPrince5, 3>(3));
  check(sim::RungeKutta<sim::DormandPrince8, 3>(3));
}

TEST_CASE("the estimate of the error is of its size, and the eigenvalue of a decay is found", "[sim][runge_kutta]") {
  const double rate = 40.0;
  const auto decay = [=](double, const double* y, double* dydt) { dydt[0] = -rate * y[0]; };
  const auto check = [&](auto formula, double h) {
    const Eigen::VectorXd start = Eigen::VectorXd::Ones(1), absolute = Eigen::VectorXd::Constant(1, 1e-9);
    formula.start(decay, 0.0, start);
    formula.step(decay, h);
    const double error = std::abs(formula.end()[0] - std::exp(-rate * h)) / 1e-9;
    CHECK(formula.error(absolute, 0.0) > error);           // that of the worse of two solutions
    CHECK(formula.error(absolute, 0.0) < 1000.0 * error);  // but not of another order of magnitude altogether
    CHECK(formula.stiffness() == Approx(rate * h).epsilon(0.05));
  };
  check(sim::RungeKutta<sim::DormandPrince5, Eigen::Dynamic>(1), 0.02);
  check(sim::RungeKutta<sim::DormandPrince8, Eigen::Dynamic>(1), 0.03);
}

TEST_CASE("a zero is bracketed to the width asked for, the far end beyond it", "[sim][zero_of]") {
  int calls = 0;
  const auto check = [&](auto g, double low, double high, double zero, int most) {
    calls = 0;
    const auto counted = [&](double t) { return ++calls, g(t); };
    const sim::Bracket found = sim::zero_of(counted, {low, high, g(low), g(high)}, 1e-14);
    CHECK(found.high >= zero - 1e-15);
    CHECK(found.high - zero <= 1e-14);
    CHECK(found.at_high * g(low) <= 0.0);
    CHECK(calls <= most);
  };
  check([](double t) { return t - 0.3; }, 0.0, 1.0, 0.3, 6);
  check([](double t) { return std::exp(5.0 * t) - std::exp(1.0); }, 0.0, 1.0, 0.2, 20);
  check([](double t) { return std::pow(t - 0.4, 3); }, 0.0, 1.0, 0.4, 200);   // flat: bisection helps
  check([](double t) { return t < 0.7 ? 1.0 : -1e-9; }, 0.0, 1.0, 0.7, 200);  // a step
  check([](double t) { return 1e-300 * (0.25 - t); }, 0.0, 1.0, 0.25, 10);    // small
}
