#include "dsp/filter/spectral.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "support/signals.hpp"

namespace test_filter_spectral {

namespace {
constexpr double rate_hz = 25.6;
constexpr dsp::SpectralBand band{.rolloff_hz = 8.0, .cutoff_hz = 10.24};

struct Record {
  Eigen::VectorXd x, v, a;
};
Record swept_record(Eigen::Index n) {
  Record record{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  const support::SweptHarmonics signal;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto point = signal.at(static_cast<double>(i) / rate_hz);
    record.x(i) = point.x + 0.012;
    record.v(i) = point.v;
    record.a(i) = point.a;
  }
  return record;
}
double interior(const Eigen::VectorXd& estimate, const Eigen::VectorXd& truth) {
  return support::nmse(estimate.segment(26, estimate.size() - 52), truth.segment(26, truth.size() - 52));
}
double ends(const Eigen::VectorXd& estimate, const Eigen::VectorXd& truth) {
  return std::max(support::nmse(estimate.head(26), truth.head(26)), support::nmse(estimate.tail(26), truth.tail(26)));
}
}  // namespace

TEST_CASE("velocity of a record that does not close on itself is exact up to its ends", "[dsp][spectral]") {
  for (const Eigen::Index n : {1500, 4001, 7777}) {
    const Record record = swept_record(n);
    const Eigen::VectorXd v = dsp::ExtendedSpectrum(record.x, rate_hz).derivative(1, band);
    CHECK(interior(v, record.v) <= 1e-8);
    CHECK(ends(v, record.v) <= 1e-8);
  }
}

TEST_CASE("derivatives of a noisy record are as good at its ends as inside", "[dsp][spectral]") {
  // 12 um at 800 Hz leaves this much below the Nyquist frequency of the regression rate.
  const double noise_std_m = 12e-6 * std::sqrt(rate_hz / 800.0);
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    Record record = swept_record(6000);
    record.x += support::gaussian(6000, seed, noise_std_m);
    const dsp::ExtendedSpectrum spectrum(record.x, rate_hz);
    const Eigen::VectorXd v = spectrum.derivative(1, band), a = spectrum.derivative(2, band);
    CHECK(interior(v, record.v) <= 5e-6);
    CHECK(ends(v, record.v) <= 5e-6);
    CHECK(interior(a, record.a) <= 1e-4);
    CHECK(ends(a, record.a) <= 1e-4);
  }
}

TEST_CASE("any response is applied: a delay delays, a high-pass takes the mean", "[dsp][spectral]") {
  const Record record = swept_record(4000);
  const dsp::ExtendedSpectrum spectrum(record.x, rate_hz);
  const double delay_s = 0.0123;
  const Eigen::VectorXd delayed =
      spectrum.filtered([&](double f) { return std::polar(1.0, -2 * std::numbers::pi * f * delay_s); });
  const support::SweptHarmonics signal;
  const Eigen::VectorXd expected = Eigen::VectorXd::NullaryExpr(
      4000, [&](Eigen::Index i) { return 0.012 + signal.at(static_cast<double>(i) / rate_hz - delay_s).x; });
  CHECK((delayed - expected).cwiseAbs().maxCoeff() <= 1e-6);  // of 8e-3; limited by the continuation at the ends

  const Eigen::VectorXd high = spectrum.filtered([](double f) { return f / std::complex<double>(f, -0.01); });
  CHECK(std::abs(high.mean()) <= 1e-5);
  CHECK((spectrum.filtered([](double) { return 1.0; }) - record.x).cwiseAbs().maxCoeff() <= 1e-15);
}

TEST_CASE("the sum of two filtered signals is the filtered signals' sum, of one length", "[dsp][spectral]") {
  const Eigen::VectorXd a = support::gaussian(500, 1), b = support::gaussian(500, 2);
  const auto twice = [](double) { return std::complex<double>(2.0, 0.0); };
  dsp::ExtendedSpectrum sum(a, 100.0);
  sum.add(dsp::ExtendedSpectrum(b, 100.0), twice);
  CHECK((std::move(sum).signal() - a - 2.0 * b).cwiseAbs().maxCoeff() < 1e-12);  // rounding of an FFT of some 1000
  dsp::ExtendedSpectrum other(a, 100.0);
  CHECK_THROWS_AS(other.add(dsp::ExtendedSpectrum(b.head(400), 100.0), twice), std::invalid_argument);
}

TEST_CASE("the fraction of power above a frequency is that of the tones above it", "[dsp][spectral]") {
  const Eigen::VectorXd x = Eigen::VectorXd::NullaryExpr(5120, [](Eigen::Index i) {
    const double t = static_cast<double>(i) / rate_hz;
    return 3.0 + std::sin(2 * std::numbers::pi * 1.5 * t) + 0.1 * std::sin(2 * std::numbers::pi * 9.0 * t + 1.0);
  });
  // The extension changes the lengths of both tones by up to a tenth.
  CHECK(dsp::ExtendedSpectrum(x, rate_hz).power_fraction_above(5.0) == Approx(0.01 / 1.01).epsilon(0.1));
}

TEST_CASE("short, constant and purely noisy records are survived", "[dsp][spectral]") {
  for (const Eigen::Index n : {8, 9, 13, 40}) {
    const Eigen::VectorXd noise = support::gaussian(n, 21);
    const Eigen::VectorXd v = dsp::ExtendedSpectrum(noise, rate_hz).derivative(1, band);
    REQUIRE(v.size() == n);
    // No more than every component at the cut-off, with the extension adding at most as much again.
    CHECK(v.norm() <= 2 * 2 * std::numbers::pi * band.cutoff_hz * noise.norm());
  }
  const dsp::ExtendedSpectrum constant(Eigen::VectorXd::Constant(1000, 1.0 / 3.0), rate_hz);
  CHECK(constant.derivative(2, band).cwiseAbs().maxCoeff() == 0.0);
  CHECK(constant.derivative(0, band)(500) == Approx(1.0 / 3.0));
  CHECK(constant.power_fraction_above(1.0) == 0.0);

  CHECK_THROWS_AS(dsp::ExtendedSpectrum(Eigen::VectorXd::Zero(7), rate_hz), std::invalid_argument);
  CHECK_THROWS_AS(dsp::ExtendedSpectrum(Eigen::VectorXd::Zero(70), 0.0), std::invalid_argument);
  Eigen::VectorXd broken = Eigen::VectorXd::Zero(70);
  broken(3) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(dsp::ExtendedSpectrum(broken, rate_hz), std::invalid_argument);
}

TEST_CASE("the band is flat, falls as a raised cosine and ends at zero", "[dsp][spectral]") {
  CHECK(band.gain(0.0) == 1.0);
  CHECK(band.gain(8.0) == 1.0);
  CHECK(band.gain(9.12) == Approx(0.5));
  CHECK(band.gain(10.24) == 0.0);
  CHECK(band.gain(12.0) == 0.0);
}

}  // namespace test_filter_spectral
