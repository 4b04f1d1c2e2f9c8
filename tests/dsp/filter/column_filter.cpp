#include "dsp/filter/column_filter.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "support/signals.hpp"

namespace test_filter_column_filter {

namespace {
constexpr double rate_hz = 50.0;
const auto taper = dsp::ColumnFilter::taper(rate_hz, {.rolloff_hz = 8.0, .cutoff_hz = 10.0});

Eigen::VectorXd tone(double frequency_hz, Eigen::Index n, double rate = rate_hz) {
  return Eigen::VectorXd::NullaryExpr(n, [&](Eigen::Index i) {
    return std::sin(2 * std::numbers::pi * frequency_hz * static_cast<double>(i) / rate + 0.4);
  });
}
}  // namespace

TEST_CASE("the taper passes its band, halves its middle and stops the rest", "[dsp][column_filter]") {
  const Eigen::Index n = 2000, edge = 100;
  const auto gain = [&](double f) {
    const Eigen::VectorXd in = tone(f, n), out = taper.apply(in);
    return out.segment(edge, n - 2 * edge).dot(in.segment(edge, n - 2 * edge)) /
           in.segment(edge, n - 2 * edge).squaredNorm();
  };
  CHECK(gain(3.0) == Approx(1.0).margin(1e-6));
  CHECK(gain(9.0) == Approx(0.5).margin(1e-3));
  CHECK(gain(12.0) == Approx(0.0).margin(1e-6));
  CHECK(taper.edge_s() == 0.5);
  CHECK(taper.input_rate_hz() == rate_hz);
  CHECK(taper.output_rate_hz() == rate_hz);
}

TEST_CASE("filtering is linear, so filtered columns fit what filtered signals fit", "[dsp][column_filter]") {
  // Away from the ends, whose continuation is fitted to each signal by itself.
  const Eigen::VectorXd a = support::gaussian(3000, 1), b = support::gaussian(3000, 2);
  const Eigen::VectorXd sum = taper.apply(2.0 * a - 3.0 * b), parts = 2.0 * taper.apply(a) - 3.0 * taper.apply(b);
  CHECK((sum - parts).segment(500, 2000).cwiseAbs().maxCoeff() <= 2e-3 * parts.cwiseAbs().maxCoeff());
}

TEST_CASE("the high-pass is that of an AC coupling: gain, lead and no DC", "[dsp][column_filter]") {
  const double cutoff_hz = 0.5, f = 1.3;
  const auto filter = taper.with_highpass({cutoff_hz});
  const Eigen::Index n = 4000, skip = 400;
  const Eigen::VectorXd out = filter.apply(Eigen::VectorXd(tone(f, n).array() + 7.0));
  const double gain = f / std::hypot(f, cutoff_hz), lead = std::atan2(cutoff_hz, f);
  const Eigen::VectorXd expected = Eigen::VectorXd::NullaryExpr(n, [&](Eigen::Index i) {
    return gain * std::sin(2 * std::numbers::pi * f * static_cast<double>(i) / rate_hz + 0.4 + lead);
  });
  CHECK((out - expected).segment(skip, n - 2 * skip).cwiseAbs().maxCoeff() <= 1e-3);
  CHECK_THROWS_AS(taper.with_highpass({0.0}), std::invalid_argument);
}

TEST_CASE("decimation keeps tones of its band in place and carries the high-pass behind it", "[dsp][column_filter]") {
  const double f = 1.3, cutoff_hz = 0.5;
  const auto filter = dsp::ColumnFilter::decimation(256.0, {.output_rate_hz = 25.6, .passband_end_hz = 10.24});
  CHECK(filter.output_rate_hz() == 25.6);
  CHECK(filter.edge_s() == filter.sheet().edge_s);
  const Eigen::VectorXd in = tone(f, 256 * 80, 256.0), out = filter.apply(in);
  REQUIRE(out.size() == 2048);
  CHECK((out - tone(f, 2048, 25.6)).cwiseAbs().maxCoeff() <= 1e-4);

  const double gain = f / std::hypot(f, cutoff_hz), lead = std::atan2(cutoff_hz, f);
  const Eigen::VectorXd coupled = filter.with_highpass({cutoff_hz}).apply(Eigen::VectorXd(in.array() + 3.0));
  for (Eigen::Index i = 200; i < 1800; ++i)
    CHECK(coupled(i) ==
          Approx(gain * std::sin(2 * std::numbers::pi * f * static_cast<double>(i) / 25.6 + 0.4 + lead)).margin(1e-3));
  // What has been decimated already takes the high-pass and becomes the same, bit for bit.
  CHECK(filter.with_highpass({cutoff_hz}).high_passed(out) == filter.with_highpass({cutoff_hz}).apply(in));
  CHECK(filter.high_passed(out) == out);
}

TEST_CASE("a band that does not fit is refused", "[dsp][column_filter]") {
  CHECK_THROWS_AS(dsp::ColumnFilter::taper(rate_hz, {.rolloff_hz = 10.0, .cutoff_hz = 10.0}), std::invalid_argument);
  CHECK_THROWS_AS(dsp::ColumnFilter::taper(rate_hz, {.rolloff_hz = 10.0, .cutoff_hz = 26.0}), std::invalid_argument);
}

}  // namespace test_filter_column_filter
