#include "dsp/filter/power_density.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "dsp/filter/fft.hpp"
#include "support/random.hpp"

using Eigen::Index;
using Eigen::VectorXd;

TEST_CASE("white noise has one density at all frequencies, of a record of any length", "[dsp][power_density]") {
  constexpr double rate_hz = 256.0, std = 0.3, density = 2.0 * std * std / rate_hz;
  for (const Index n : {2003, 16457, 65536, 104729})  // primes, what comes of pieces, a power of two
    for (const Index piece : {Index{0}, Index{1000}}) {
      const VectorXd noise = std * support::gaussian(n, 1, static_cast<unsigned>(n));
      const dsp::PowerDensity found(noise, rate_hz, piece);
      // The median of N exponentially distributed ordinates errs by 1 / (ln 2 sqrt(N)) of itself; under Hann's window
      // half of them count.
      const double error = 1.0 / (0.69 * std::sqrt(0.25 * static_cast<double>(n)));
      CHECK(found.between(0.0, 0.5 * rate_hz) == Approx(density).epsilon(4.0 * error + 0.01));
      CHECK(found.ordinates().sum() * found.step_hz() == Approx(std * std).epsilon(8.0 / std::sqrt(n)));
    }
}

TEST_CASE("a power density is the periodogram of the windowed signal", "[dsp][power_density]") {
  constexpr double rate_hz = 100.0;
  for (const Index n : {8, 60, 4096}) {
    const VectorXd signal = support::gaussian(n, 1, 3).array() + 5.0 * VectorXd::LinSpaced(n, 0.0, 1.0).array();
    const VectorXd window = dsp::hann_window(n);
    const VectorXd windowed = (signal.array() - signal.mean()) * window.array();
    const VectorXd expected = dsp::RealFft(n).forward(windowed).cwiseAbs2() * (2.0 / (rate_hz * window.squaredNorm()));
    const dsp::PowerDensity density(signal, rate_hz);
    const VectorXd& found = density.ordinates();
    CHECK((found - expected).norm() <= 1e-13 * expected.norm());  // rounding of the transform
  }
}
