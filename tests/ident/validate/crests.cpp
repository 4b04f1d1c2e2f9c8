#include "ident/validate/crests.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

using Eigen::Index;
using Eigen::VectorXd;

namespace {

VectorXd sampled(double duration_s, double (*x)(double)) {
  VectorXd result(static_cast<Index>(100.0 * duration_s));
  for (Index i = 0; i < result.size(); ++i) result(i) = x(static_cast<double>(i) / 100.0);
  return result;
}

constexpr double two_pi = 2.0 * std::numbers::pi;

}  // namespace

TEST_CASE("every whole cycle has one crest, about the mean") {
  const auto found = ident::crests(sampled(10.0, [](double t) { return 5.0 + 2.0 * std::sin(two_pi * t - 0.1); }));
  REQUIRE(found.size() == 9);
  for (const double crest : found) CHECK(crest == Approx(2.0).epsilon(2e-3));  // a hundred samples a cycle
}

TEST_CASE("free decays, limit cycles and steady motion renew no amplitude, a beat does") {
  const auto renewed = [](const VectorXd& x) { return ident::renewed_amplitude(ident::crests(x), 0.2); };
  CHECK(renewed(sampled(60.0, [](double t) { return std::exp(-0.05 * t) * std::sin(two_pi * t); })) == 0.0);
  CHECK(renewed(sampled(60.0, [](double t) { return (1.0 - std::exp(-0.1 * t)) * std::sin(two_pi * t); })) == 0.0);
  CHECK(renewed(sampled(60.0, [](double t) { return std::sin(two_pi * t); })) == 0.0);
  // Between 0 and 2 every 20 s: five falls and four or five rises in 100 s.
  const double beat =
      renewed(sampled(100.0, [](double t) { return std::sin(two_pi * t) + std::sin(two_pi * 1.05 * t); }));
  CHECK(beat > 3.5);
  CHECK(beat < 5.5);
}

TEST_CASE("noise that passes the mean many times makes no cycles of its own") {
  std::mt19937 random(5);
  std::normal_distribution<double> white(0.0, 0.1);
  VectorXd x = sampled(60.0, [](double t) { return std::sin(0.2 * two_pi * t); });
  for (double& value : x) value += white(random);
  CHECK(ident::crests(x).size() > 20);
  const auto found = ident::crests(x, 0.4);
  CHECK(found.size() == 10);
  CHECK(ident::renewed_amplitude(ident::crests(x), 0.8) > 1.0);
  CHECK(ident::renewed_amplitude(found, 0.8) == 0.0);
}

TEST_CASE("noise below the least turn renews nothing") {
  std::mt19937 random(4);
  std::normal_distribution<double> white(0.0, 0.02);
  std::vector<double> crests;
  for (int i = 0; i < 500; ++i) crests.push_back(std::exp(-i / 300.0) + white(random));
  CHECK(ident::renewed_amplitude(crests, 8.0 * 0.02) == 0.0);
  CHECK(ident::renewed_amplitude({}, 0.1) == 0.0);
}
