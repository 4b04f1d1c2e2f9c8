#include "apps/page/physical_terms.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double pi = std::numbers::pi;

ident::Model model_of(const std::string& target, const std::vector<std::pair<std::string, double>>& terms) {
  ident::Model model;
  model.target = target;
  for (const auto& [name, mean] : terms) model.terms.push_back({.name = name, .mean = mean});
  model.covariance = MatrixXd::Zero(std::ssize(terms), std::ssize(terms));
  return model;
}

/// NaN: there is none of this name.
apps::PhysicalTerm named(const std::vector<apps::PhysicalTerm>& terms, const std::string& name) {
  for (const apps::PhysicalTerm& term : terms)
    if (term.name.starts_with(name)) return term;
  return {name, "", std::nan(""), std::nan("")};
}

}  // namespace

TEST_CASE("coefficients mean what they do by hand", "[apps][page]") {
  const auto model = model_of("a", {{"x", -50.0}, {"v", -0.8}, {"x^3", -95'000.0}, {"sgn(v)", -0.08}, {"ddr", -1.0}});
  const auto terms = apps::physical_terms(model, {-0.01, 0.01, "m"});
  CHECK(named(terms, "natural frequency").value == Approx(std::sqrt(50.0) / (2 * pi)));
  CHECK(named(terms, "damping ratio").value == Approx(100.0 * 0.8 / (2.0 * std::sqrt(50.0))));
  CHECK(named(terms, "friction force per mass").value == Approx(0.08));
  CHECK(named(terms, "hardening").value == Approx(95'000.0));
  // Of the undamped cubic oscillator by elliptic integrals: omega = pi sqrt(k + k3 A^2) / (2 K(m)).
  const double bent = 50.0 + 9.5;
  CHECK(named(terms, "frequency at").value ==
        Approx(std::sqrt(bent) / (4.0 * std::comp_ellint_1(std::sqrt(0.5 * 9.5 / bent)))).epsilon(1e-10));
  CHECK(named(terms, "friction").unit == "m/s^2");
  const auto fed = model_of("a", {{"x", -50.0}, {"v", 0.8}, {"sgn(v)", 0.08}});
  const auto negative = apps::physical_terms(fed, {-0.01, 0.01, "m"});
  CHECK(named(negative, "negative damping ratio").value == Approx(-100.0 * 0.8 / (2.0 * std::sqrt(50.0))));
  CHECK(named(negative, "negative friction force per mass").value == Approx(-0.08));
}

TEST_CASE("the same motion written another way means the same", "[apps][page]") {
  const auto plain = model_of("a", {{"x", -50.0}, {"v", -0.8}, {"sgn(v)", -0.08}});
  const auto force = model_of("f", {{"a", 2.0}, {"x", 100.0}, {"v", 1.6}, {"sgn(v)", 0.16}});  // of 2 kg
  const auto absolute = model_of("ddy", {{"y", -50.0}, {"dy", -0.8}, {"sgn(dy)", -0.08}});
  const auto sine = model_of("a", {{"sin(x)", -50.0}, {"v", -0.8}, {"sgn(v)", -0.08}});
  for (const auto* model : {&plain, &force, &absolute, &sine}) {
    const auto terms = apps::physical_terms(*model, {0.0, 0.0, "m", model == &absolute});
    for (const auto& expected : apps::physical_terms(plain, {0.0, 0.0, "m"})) {
      CAPTURE(model->target, expected.name);
      CHECK(named(terms, expected.name).value == Approx(expected.value).epsilon(1e-12));
    }
  }
  CHECK(named(apps::physical_terms(sine, {0.0, 0.0, "rad"}), "softening").value == Approx(-50.0 / 6.0));
}

TEST_CASE("a payload between two magnets rests on either side of the middle", "[apps][page]") {
  const auto model = model_of("a", {{"x", 20.0}, {"x^3", -5000.0}});
  const auto terms = apps::physical_terms(model, {0.0, 0.0, "m"});
  CHECK(std::isnan(named(terms, "natural frequency").value) == false);
  CHECK(named(terms, "rest positions").value == Approx(std::sqrt(20.0 / 5000.0)));
  const double at = std::sqrt(20.0 / 5000.0), stiffness_there = -20.0 + 3.0 * 5000.0 * at * at;
  CHECK(named(terms, "natural frequency about them").value == Approx(std::sqrt(stiffness_there) / (2 * pi)));
  CHECK(std::isnan(named(terms, "damping").value));
}

TEST_CASE("their uncertainty is that of drawn coefficients", "[apps][page][random]") {
  auto model = model_of("a", {{"x", -50.0}, {"v", -0.8}, {"x^3", -95'000.0}});
  const Eigen::Vector3d std(0.5, 0.03, 2000.0);
  Eigen::Matrix3d correlation;
  correlation << 1.0, 0.3, -0.8, 0.3, 1.0, 0.1, -0.8, 0.1, 1.0;
  model.covariance = std.asDiagonal() * correlation * std.asDiagonal();
  const auto terms = apps::physical_terms(model, {-0.01, 0.01, "m"});
  const MatrixXd root = model.covariance.llt().matrixL();
  std::mt19937_64 draw(3);
  std::normal_distribution<double> normal;
  std::vector<VectorXd> sums(terms.size(), VectorXd::Zero(2));
  constexpr int num_draws = 40'000;
  for (int i = 0; i < num_draws; ++i) {
    auto drawn = model;
    const VectorXd change = root * VectorXd::NullaryExpr(3, [&] { return normal(draw); });
    for (int k = 0; k < 3; ++k) drawn.terms[static_cast<std::size_t>(k)].mean += change(k);
    drawn.covariance.resize(0, 0);
    const auto values = apps::physical_terms(drawn, {-0.01, 0.01, "m"});
    REQUIRE(values.size() == terms.size());
    for (std::size_t k = 0; k < terms.size(); ++k) {
      CHECK(std::isnan(values[k].std));  // without a covariance there is none
      const double from_mean = values[k].value - terms[k].value;
      sums[k] += Eigen::Vector2d(from_mean, from_mean * from_mean);
    }
  }
  for (std::size_t k = 0; k < terms.size(); ++k) {
    CAPTURE(terms[k].name);
    const double mean = sums[k](0) / num_draws;
    CHECK(terms[k].std == Approx(std::sqrt(sums[k](1) / num_draws - mean * mean)).epsilon(0.02));
  }
}

TEST_CASE("a pendulum is described about where it hangs, wherever its angle is counted from", "[apps][page]") {
  // 64 sin x with x about pi, by its polynomial: -64 (u - u^3 / 6) in u = x - pi.
  const double w = 64.0;
  auto model = model_of("a", {{"1", w * pi - w * pi * pi * pi / 6.0},
                              {"x", -w + w * pi * pi / 2.0},
                              {"x^2", -w * pi / 2.0},
                              {"x^3", w / 6.0},
                              {"v", -0.1}});
  model.covariance(0, 0) = 1.0;  // of the constant: it hangs 1 / 64 aside
  const auto terms = apps::physical_terms(model, {2.4, 3.8, "rad"});
  CHECK(named(terms, "rest position").value == Approx(pi));
  CHECK(named(terms, "rest position").std == Approx(1.0 / w));
  CHECK(named(terms, "natural frequency about it").value == Approx(std::sqrt(w) / (2 * pi)));
  CHECK(named(terms, "natural frequency about it").std == Approx(0.0).margin(1e-6));  // it is softest there
  CHECK(named(terms, "damping ratio").value == Approx(100.0 * 0.1 / (2.0 * std::sqrt(w))));
  CHECK(named(terms, "softening").value == Approx(-w / 6.0));
  const auto sine = model_of("a", {{"sin(x)", w}});
  CHECK(named(apps::physical_terms(sine, {2.4, 3.8, "rad"}), "natural frequency").value ==
        Approx(std::sqrt(w) / (2 * pi)));
  // It does not come by where it would rest.
  CHECK(apps::physical_terms(model, {3.3, 3.8, "rad"}).empty());
}

TEST_CASE("about a rest aside of the middle of a cubic spring the frequency falls", "[apps][page]") {
  // Between two magnets, 50 x - 5e4 x^3: about x = sqrt(1e-3) k = 100, k2 = 3 k3 x, k3 = 5e4.
  const auto model = model_of("a", {{"x", 50.0}, {"x^3", -5e4}});
  const auto terms = apps::physical_terms(model, {0.02, 0.045, "m"});
  const double rest = std::sqrt(1e-3), k2 = 3 * 5e4 * rest;
  REQUIRE(named(terms, "rest position").value == Approx(rest));
  CHECK(named(terms, "natural frequency about it").value == Approx(std::sqrt(100.0) / (2 * pi)));
  CHECK(std::isnan(named(terms, "hardening").value));
  // It turns at x with 2e-3 - x^2 = 0.02^2, too: by the second order of perturbation for half of that swing. From the
  // upper end it would go over the hill to the other magnet.
  CHECK(named(terms, "frequency at").name == "frequency at 0.0116 m amplitude");
  const double swing = 0.5 * (std::sqrt(2e-3 - 4e-4) - 0.02);
  const double square = 100.0 + (0.75 * 5e4 - 5.0 / 6.0 * k2 * k2 / 100.0) * swing * swing;
  CHECK(named(terms, "frequency at").value == Approx(std::sqrt(square) / (2 * pi)).epsilon(3e-3));
  CHECK(named(terms, "frequency at").value < std::sqrt(100.0) / (2 * pi));
}

TEST_CASE("a pendulum's frequency is that of its swing, however wide", "[apps][page]") {
  auto model = model_of("a", {{"sin(x)", -16.0}, {"v", -0.1}});
  model.covariance(0, 0) = 0.04;
  for (const double wide : {0.1, 1.0, 2.0, 3.0}) {
    const auto terms = apps::physical_terms(model, {-wide, wide, "rad"});
    const double hz = 4.0 / (4.0 * std::comp_ellint_1(std::sin(wide / 2.0)));
    CHECK(named(terms, "frequency at").value == Approx(hz).epsilon(1e-9));
    CHECK(named(terms, "frequency at").std == Approx(hz * 0.2 / (2.0 * 16.0)).epsilon(1e-4));  // as sqrt(16)
  }
  // With its mass beside, and where x = 0 is not its rest.
  const auto heavy = model_of("f", {{"a", 2.0}, {"sin(x)", 32.0}});
  CHECK(named(apps::physical_terms(heavy, {-2.0, 2.0, "rad"}), "frequency at").value ==
        Approx(1.0 / std::comp_ellint_1(std::sin(1.0))).epsilon(1e-9));
  // A signed square, (x'' = -9 |x| x): T = 4 sqrt(3 / (2 * 9 A)) B(1/3, 1/2) / 3, by the energy.
  const auto signed_square = model_of("a", {{"x", -1e-9}, {"x^3", -1e-9}, {"sgn(x)*x^2", -9.0}});
  const double period_s = 4.0 * std::sqrt(3.0 / (2.0 * 9.0 * 2.0)) * std::beta(1.0 / 3.0, 0.5) / 3.0;
  CHECK(named(apps::physical_terms(signed_square, {-2.0, 2.0, "m"}), "frequency at").value ==
        Approx(1.0 / period_s).epsilon(1e-4));  // a third derivative jumps at 0
  // 50 u + 1e4 u^3 about u = 0, with x counted from 0.01 beside it: amplitude and frequency are those of u.
  const auto aside =
      model_of("a", {{"1", 50.0 * 0.01 + 1e4 * 1e-6}, {"x", -50.0 - 3e4 * 1e-4}, {"x^2", 3e4 * 0.01}, {"x^3", -1e4}});
  const auto there = apps::physical_terms(aside, {-0.01, 0.03, "m"});
  const double bent = 50.0 + 1e4 * 4e-4;
  CHECK(named(there, "frequency at").name == "frequency at 0.02 m amplitude");
  CHECK(named(there, "frequency at").value ==
        Approx(std::sqrt(bent) / (4.0 * std::comp_ellint_1(std::sqrt(0.5 * 4.0 / bent)))).epsilon(1e-8));
  // Beyond the top of a softening spring it does not come back: from the other end it does.
  const auto soft = model_of("a", {{"x", -50.0}, {"x^3", 5e4}});
  CHECK(named(apps::physical_terms(soft, {-0.02, 0.05, "m"}), "frequency at").name == "frequency at 0.02 m amplitude");
  // Over the top it does not come back.
  CHECK(std::isnan(named(apps::physical_terms(model, {-3.2, 3.2, "rad"}), "frequency at").value));
}
