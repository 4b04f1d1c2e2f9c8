#include "dsp/sensors/sensor_consistency.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "dsp/filter/spectral.hpp"
#include "dsp/prepare/power_check.hpp"
#include "support/signals.hpp"

namespace test_sensors_sensor_consistency {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 64.0, two_pi = 2.0 * std::numbers::pi;

// A stepped sine with harmonics, 600 s: displacement and the acceleration a sensor with these faults reports of it.
struct Pair {
  VectorXd displacement, acceleration;
};

Pair sensors(double gain, double lag_s, const std::vector<double>& cutoffs_hz, double noise, unsigned seed) {
  const Index n = static_cast<Index>(600 * rate_hz);
  support::SweptHarmonics motion;
  VectorXd x(n), a(n);
  for (Index i = 0; i < n; ++i) {
    const auto point = motion.at(static_cast<double>(i) / rate_hz);
    x(i) = point.x;
    a(i) = gain * point.a;
  }
  Pair pair;
  pair.displacement =
      dsp::ExtendedSpectrum(x, rate_hz).filtered([&](double f) { return std::polar(1.0, -two_pi * f * lag_s); });
  pair.acceleration =
      dsp::ExtendedSpectrum(a, rate_hz).filtered([&](double f) { return dsp::highpass_response(cutoffs_hz, f); });
  pair.displacement += support::gaussian(n, seed, noise * 2e-6);
  pair.acceleration += support::gaussian(n, seed + 1, noise * 2e-3);
  return pair;
}

}  // namespace

TEST_CASE("gain, lag and cut-offs between two sensors come from their record", "[dsp][sensor_consistency]") {
  struct Case {
    double gain, lag_s;
    std::vector<double> cutoffs_hz;
  };
  for (const Case& truth : {Case{1.017, 1.2e-3, {0.40}}, Case{0.989, 0.0, {}}, Case{1.02, 3e-3, {0.45, 0.30}}}) {
    const Pair pair = sensors(truth.gain, truth.lag_s, truth.cutoffs_hz, 1.0, 11);
    const auto found = dsp::relate_sensors(pair.displacement, pair.acceleration, rate_hz, {});
    INFO("gain " << truth.gain << " cut-offs " << truth.cutoffs_hz.size());
    REQUIRE(found.reason.empty());
    REQUIRE(found.highpass_hz.size() == truth.cutoffs_hz.size());
    CHECK(found.gain == Approx(truth.gain).margin(5e-4 * (1.0 + 3.0 * static_cast<double>(truth.cutoffs_hz.size()))));
    CHECK(found.lag_s == Approx(truth.lag_s).margin(1.5e-4));
    if (truth.cutoffs_hz.size() == 1) CHECK(found.highpass_hz[0] == Approx(truth.cutoffs_hz[0]).margin(5e-3));
    if (truth.cutoffs_hz.size() == 2)  // above both cut-offs only their sum shows
      CHECK(found.highpass_hz[0] + found.highpass_hz[1] == Approx(0.75).margin(0.02));
  }
}

TEST_CASE("excluded intervals do not take part", "[dsp][sensor_consistency]") {
  Pair pair = sensors(1.017, 1.2e-3, {0.40}, 1.0, 21);
  std::vector<unsigned char> excluded(static_cast<std::size_t>(pair.displacement.size()), 0);
  for (Index i = 6400; i < 7400; ++i) {
    pair.displacement(i) = 0.05;
    excluded[static_cast<std::size_t>(i)] = 1;
  }
  const auto found = dsp::relate_sensors(pair.displacement, pair.acceleration, rate_hz, excluded);
  CHECK(found.gain == Approx(1.017).margin(2e-3));
  std::fill(excluded.begin(), excluded.end(), 1);
  CHECK_FALSE(dsp::relate_sensors(pair.displacement, pair.acceleration, rate_hz, excluded).reason.empty());
}

TEST_CASE("two sensors of different motions are not related", "[dsp][sensor_consistency]") {
  const Pair pair = sensors(1.0, 0.0, {}, 1.0, 31);
  CHECK_FALSE(dsp::relate_sensors(pair.displacement, support::gaussian(pair.displacement.size(), 1), rate_hz, {})
                  .reason.empty());
}

TEST_CASE("power that cannot be there shows a phase error and goes with it", "[dsp][sensor_consistency]") {
  const Pair pair = sensors(1.017, 1.2e-3, {0.40}, 0.0, 41);
  dsp::Recording recording{.name = "pair", .sample_rate_hz = rate_hz};
  recording.channels = {{.name = "laser", .role = dsp::Role::y, .unit = "m"},
                        {.name = "acc", .role = dsp::Role::ddy, .unit = "m/s^2"}};
  recording.samples.resize(pair.displacement.size(), 2);
  recording.samples << pair.displacement, pair.acceleration;
  std::vector<unsigned char> use(static_cast<std::size_t>(pair.displacement.size()), 1);
  const dsp::SpectralBand band{12.0, 20.0};
  const auto rho = [&](const std::vector<double>& highpass_hz) {
    const VectorXd v = dsp::ExtendedSpectrum(recording.samples.col(0), rate_hz).derivative(1, band);
    const VectorXd same =
        dsp::ExtendedSpectrum(v, rate_hz).filtered([&](double f) { return dsp::highpass_response(highpass_hz, f); });
    return dsp::power_balance(same, recording.samples.col(1), use);
  };
  CHECK(std::abs(rho({})) > 0.2);  // atan(0.4 / 1.6) = 14 degrees: sine 0.24
  dsp::ColumnSpectra spectra(recording);
  const auto equal = dsp::equalise_sensors(spectra, {});
  spectra.store();
  REQUIRE(equal.highpass_hz.size() == 1);
  CHECK(std::abs(rho(equal.highpass_hz)) <= 2e-3);
}

TEST_CASE("low frequencies that an AC coupling took come back from the displacement, high ones from the accelerometer",
          "[dsp][sensor_consistency]") {
  const std::vector<double> cutoffs_hz{0.4, 0.3};
  const Index n = 256 * 120;
  VectorXd x(n), a(n);
  for (Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / rate_hz;
    const double slow = 2.0 * std::numbers::pi * 0.05, fast = 2.0 * std::numbers::pi * 1.6;
    x(i) = 0.2 * std::sin(slow * t) + 5e-3 * std::sin(fast * t + 0.3);
    a(i) = -0.2 * slow * slow * std::sin(slow * t) - 5e-3 * fast * fast * std::sin(fast * t + 0.3);
  }
  dsp::Recording recording{.name = "pair", .sample_rate_hz = rate_hz};
  recording.channels = {{.name = "laser", .role = dsp::Role::y}, {.name = "acc", .role = dsp::Role::ddy}};
  recording.samples.resize(n, 2);
  recording.samples.col(0) = x;
  recording.samples.col(1) =
      dsp::ExtendedSpectrum(a, rate_hz).filtered([&](double f) { return dsp::highpass_response(cutoffs_hz, f); });
  recording.samples.col(1).array() += 0.02;
  dsp::ColumnSpectra spectra(recording);
  dsp::restore_low_frequencies(spectra, cutoffs_hz);
  spectra.store();
  // Away from the ends, where the AC coupling's past is unknown.
  const Index skip = 256 * 20;
  CHECK((recording.samples.col(1) - a).segment(skip, n - 2 * skip).cwiseAbs().maxCoeff() <=
        5e-3 * a.cwiseAbs().maxCoeff());
}

TEST_CASE("a motion whose frequency lies between those of the window is related as well as any other",
          "[dsp][sensor_consistency]") {
  // 1.46 Hz is 0.4 of the way between two frequencies of a 40 s window, where the phase of a 0.4 Hz cut-off has moved
  // on by 2e-3. Nothing but that motion and two like it.
  const Index n = static_cast<Index>(900 * rate_hz);
  VectorXd x(n), a(n);
  for (Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / rate_hz;
    const double w = two_pi * (t < 300.0 ? 1.46 : t < 600.0 ? 1.16 : 0.94);
    x(i) = 4.5e-3 * std::sin(w * t);
    a(i) = -w * w * x(i);
  }
  const double lag_s = 1.2e-3;
  const std::vector<double> cutoffs_hz{0.4};
  const VectorXd displacement =
      dsp::ExtendedSpectrum(x, rate_hz).filtered([&](double f) { return std::polar(1.0, -two_pi * f * lag_s); });
  const VectorXd acceleration =
      dsp::ExtendedSpectrum(a, rate_hz).filtered([&](double f) { return dsp::highpass_response(cutoffs_hz, f); });
  std::vector<unsigned char> excluded(static_cast<std::size_t>(n), 0);
  for (const int change : {300, 600})  // the leap there is no motion
    std::fill_n(excluded.begin() + static_cast<Index>((change - 1.0) * rate_hz),
                static_cast<std::size_t>(2.0 * rate_hz), static_cast<unsigned char>(1));
  const auto found = dsp::relate_sensors(displacement, acceleration, rate_hz, excluded);
  REQUIRE(found.highpass_hz.size() == 1);
  // Without noise: what is left are the window's skirts and the ends of the record.
  CHECK(found.lag_s == Approx(lag_s).margin(1e-5));
  CHECK(found.highpass_hz[0] == Approx(0.4).margin(2e-4));
}

}  // namespace test_sensors_sensor_consistency
