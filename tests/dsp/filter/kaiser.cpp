#include "dsp/filter/kaiser.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

TEST_CASE("Kaiser's window is the ratio of modified Bessel functions", "[dsp][kaiser]") {
  for (const double beta : {0.5, 4.0, 9.0, 14.0}) {
    const dsp::KaiserWindow window(beta);
    // Both sums are good to some roundings.
    for (const double u : {-1.0, -0.7, 0.0, 0.3, 0.99})
      CHECK(
          window(u) ==
          Approx(std::cyl_bessel_i(0.0, beta * std::sqrt(1.0 - u * u)) / std::cyl_bessel_i(0.0, beta)).epsilon(1e-14));
    CHECK(window(1.01) == 0.0);
  }
}

TEST_CASE("a low-pass of Kaiser's length and shape is as far down as was asked", "[dsp][kaiser]") {
  for (const double attenuation_db : {40.0, 60.0, 90.0}) {
    const double rate_hz = 1000.0, pass_hz = 100.0, stop_hz = 130.0, cut = 0.5 * (pass_hz + stop_hz) / rate_hz;
    const int half = static_cast<int>(std::ceil(0.5 * dsp::kaiser_length(attenuation_db, stop_hz - pass_hz, rate_hz)));
    const dsp::KaiserWindow window(dsp::kaiser_beta(attenuation_db));
    const auto gain = [&](double frequency_hz) {
      std::complex<double> sum = 2.0 * cut;
      for (int i = 1; i <= half; ++i)
        sum += 2.0 * std::sin(2.0 * std::numbers::pi * cut * i) / (std::numbers::pi * i) *
               window(static_cast<double>(i) / half) * std::cos(2.0 * std::numbers::pi * frequency_hz / rate_hz * i);
      return std::abs(sum);
    };
    double largest = 0.0;
    for (double f = stop_hz; f <= 500.0; f += 0.5) largest = std::max(largest, gain(f));
    CHECK(20.0 * std::log10(largest) < 1.5 - attenuation_db);  // Kaiser's formulas are empirical, good to about 1 dB
    CHECK(gain(0.0) == Approx(1.0).margin(2.0 * std::pow(10.0, -attenuation_db / 20.0)));
  }
}
