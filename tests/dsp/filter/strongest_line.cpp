#include "dsp/filter/strongest_line.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

TEST_CASE("the strongest line is the larger of two tones, whatever the offset", "[dsp][strongest_line]") {
  const double rate_hz = 100.0;
  const Eigen::VectorXd signal = Eigen::VectorXd::NullaryExpr(1000, [&](Eigen::Index i) {
    const double phase = 2.0 * std::numbers::pi * static_cast<double>(i) / rate_hz;
    return 50.0 + 2.0 * std::sin(7.0 * phase) + std::sin(20.0 * phase);
  });
  const dsp::SpectralLine line = dsp::strongest_line(signal, rate_hz);
  CHECK(line.frequency_hz == Approx(7.0));            // both tones fall on a bin
  CHECK(line.fraction == Approx(0.8).epsilon(1e-9));  // 4 of 4 + 1
}
