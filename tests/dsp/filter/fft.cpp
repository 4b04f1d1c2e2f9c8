#include "dsp/filter/fft.hpp"

#include <rapidcheck/catch.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <numbers>

#include "support/signals.hpp"

TEST_CASE("the transform equals the defining sum and its inverse leads back", "[dsp][fft]") {
  for (const Eigen::Index n : {1, 2, 7, 8, 30, 49, 2100}) {
    const Eigen::VectorXd x = support::gaussian(n, 3);
    const dsp::RealFft fft(n);
    const Eigen::VectorXcd X = fft.forward(x);
    REQUIRE(X.size() == n / 2 + 1);
    const double tolerance = static_cast<double>(n) * 1e-15 * x.norm();
    for (Eigen::Index k = 0; k < X.size(); ++k) {
      std::complex<double> sum = 0.0;
      for (Eigen::Index i = 0; i < n; ++i)
        sum += x(i) * std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(i * k % n) / static_cast<double>(n));
      CHECK(std::abs(X(k) - sum) <= tolerance);
    }
    CHECK((fft.inverse(X) - x).norm() <= tolerance);
  }
  CHECK_THROWS_AS(dsp::RealFft(0), std::invalid_argument);
  CHECK_THROWS_AS(dsp::RealFft(8).forward(Eigen::VectorXd::Zero(7)), std::invalid_argument);
}

namespace {

bool is_even_with_small_factors(Eigen::Index m) {
  if (m % 2 != 0) return false;
  for (const Eigen::Index p : {2, 3, 5, 7})
    while (m % p == 0) m /= p;
  return m == 1;
}

}  // namespace

TEST_CASE("a good size is the nearest even number with small factors, above or below", "[dsp][fft]") {
  rc::prop("brute force agrees", [] {
    const auto n = *rc::gen::inRange<Eigen::Index>(1, 20000);
    Eigen::Index above = n, below = std::max<Eigen::Index>(2, n);
    while (!is_even_with_small_factors(above)) ++above;
    while (!is_even_with_small_factors(below)) --below;
    RC_ASSERT(dsp::good_fft_size(n) == above);
    RC_ASSERT(dsp::good_fft_size_within(n) == below);
  });
  CHECK(dsp::good_fft_size(0) == 2);
  CHECK(dsp::good_fft_size_within(0) == 2);
}

TEST_CASE("transforms of one size give the same bits from any plan", "[dsp][fft]") {
  const Eigen::VectorXd x = support::gaussian(1260, 5);
  CHECK(dsp::RealFft(1260).forward(x) == dsp::RealFft(1260).forward(x));
}
