// Whether one equation holds in the whole band: of a record as it is, and of one whose force an anti-alias filter
// turned.
#include "ident/validate/band_split.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <string>

#include "dsp/filter/spectral.hpp"
#include "ident/identify.hpp"
#include "ident/record.hpp"
#include "support/random.hpp"

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// a = -40 x - 0.8 v - 30 x^3 + f under five tones of 0.6 to 1.3 Hz: the cube reaches to 3.9 Hz. `turn_rad`: phase that
/// the force's channel loses at 4 Hz, with the fourth power of the frequency.
dsp::Recording recorded(double turn_rad) {
  constexpr double rate_hz = 12.0;
  constexpr Index n = 12'000;
  constexpr std::array tones_hz{0.61, 0.77, 0.93, 1.09, 1.27};
  VectorXd x = VectorXd::Zero(n), v = x, a = x;
  for (std::size_t i = 0; i < tones_hz.size(); ++i) {
    const double omega = 2.0 * M_PI * tones_hz[i];
    for (Index k = 0; k < n; ++k) {
      const double phase = omega * static_cast<double>(k) / rate_hz + 1.7 * static_cast<double>(i * i);
      x(k) += 0.3 * std::sin(phase);
      v(k) += 0.3 * omega * std::cos(phase);
      a(k) -= 0.3 * omega * omega * std::sin(phase);
    }
  }
  const VectorXd force = a + 40.0 * x + 0.8 * v + 30.0 * x.array().cube().matrix();
  dsp::Recording recording{.name = "duffing", .sample_rate_hz = rate_hz};
  recording.channels = {{.name = "x", .role = dsp::Role::x, .unit = "m"},
                        {.name = "f", .role = dsp::Role::f, .unit = "N"}};
  recording.samples = 1e-4 * support::gaussian(n, 2, 71);
  recording.samples.col(0) += x;
  recording.samples.col(1) += dsp::ExtendedSpectrum(force, rate_hz).filtered([&](double f_hz) {
    return std::polar(1.0, -turn_rad * std::pow(f_hz / 4.0, 4));
  });
  return recording;
}

ident::BandSplit split_of(double turn_rad) {
  const auto found = ident::identify(ident::find_regimes(dsp::prepare(recorded(turn_rad), {})),
                                     {.order = 3, .terms = {"f"}}, {.methods = {ident::FastRvmOptions{}}});
  REQUIRE(found.front().fits.front().band);
  return *found.front().fits.front().band;
}

}  // namespace

TEST_CASE("the lower octave gives the coefficients of the band unless products lost their phase", "[ident][band]") {
  const ident::BandSplit whole = split_of(0.0), turned = split_of(1.5);
  CHECK(whole.term == "");
  CHECK(whole.holds_to_hz == whole.stop_hz);
  CHECK(whole.stop_hz == Approx(0.4 * 12.0));
  CHECK(turned.term != "");
  CHECK(turned.holds_to_hz < turned.stop_hz);
}
