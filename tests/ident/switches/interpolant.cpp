#include "ident/switches/interpolant.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

namespace {
/// Largest error, as a fraction of the amplitude, of a tone at `fraction` of the Nyquist frequency between its samples.
double tone_error(double fraction) {
  const double rate = 50.0, omega = std::numbers::pi * rate * fraction;
  const auto tone = [&](double t) { return std::sin(omega * t + 0.3); };
  const Eigen::VectorXd samples =
      Eigen::VectorXd::NullaryExpr(400, [&](Eigen::Index i) { return tone(static_cast<double>(i) / rate); });
  const ident::Interpolant between(samples, rate, 50, 350);
  double worst = 0.0;
  for (double t = 1.1; t < 6.9; t += 0.00317) worst = std::max(worst, std::abs(between.at(t) - tone(t)));
  return worst;
}
}  // namespace

TEST_CASE("a tone is found between its samples", "[ident][interpolant]") {
  // Kaiser window: 5e-5 in the pass band; Hermite pieces of h = 1/8 sample: (omega h)^4 / 384.
  for (const double fraction : {0.05, 0.2, 0.5}) CHECK(tone_error(fraction) < 1e-4);
  CHECK(tone_error(0.8) < 1e-3);
}

TEST_CASE("samples are met exactly and the ends hold", "[ident][interpolant]") {
  const Eigen::VectorXd samples = Eigen::VectorXd::Random(30);
  const ident::Interpolant between(samples, 10.0, 0, 30);
  for (Eigen::Index i = 0; i < 30; ++i)
    CHECK(between.at(static_cast<double>(i) / 10.0) == Approx(samples(i)).margin(1e-12));
  CHECK(between.at(-1.0) == samples(0));
  CHECK(between.at(99.0) == samples(29));
  CHECK_THROWS_AS(ident::Interpolant(samples, 10.0, 5, 5), std::invalid_argument);
  CHECK_THROWS_AS(ident::Interpolant(samples, 10.0, 0, 31), std::invalid_argument);
}
