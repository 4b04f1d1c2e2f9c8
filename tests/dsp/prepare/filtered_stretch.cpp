#include "dsp/prepare/filtered_stretch.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "support/signals.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 256.0, row_hz = 25.6;
constexpr Index num_samples = 120 * 256;

dsp::Prepared prepared(dsp::ColumnFilter filter, const std::vector<double>& highpass_hz) {
  dsp::Prepared made;
  made.filter = highpass_hz.empty() ? std::move(filter) : filter.with_highpass(highpass_hz);
  made.highpass_hz = highpass_hz;
  const double of_rows = made.filter.output_rate_hz();
  made.intermediate.sample_rate_hz = rate_hz;
  made.intermediate.signals.push_back({"x", "m", VectorXd::Zero(num_samples)});
  made.signals.sample_rate_hz = of_rows;
  made.signals.signals.push_back({"x", "m", VectorXd::Zero(static_cast<Index>(num_samples * of_rows / rate_hz))});
  return made;
}

dsp::ColumnFilter decimation() {
  return dsp::ColumnFilter::decimation(rate_hz, {.output_rate_hz = row_hz, .passband_end_hz = 10.24});
}

/// A motion with harmonics and an offset, and noise.
VectorXd signal() {
  const support::SweptHarmonics motion;
  VectorXd x(num_samples);
  for (Index i = 0; i < x.size(); ++i) x(i) = 0.004 + motion.at(static_cast<double>(i) / rate_hz).x;
  return x + support::gaussian(x.size(), 3, 1e-5);
}

/// Largest difference within the stretch between the whole column and one of the stretch alone, over the column's
/// largest value.
double difference(const dsp::Prepared& how, const dsp::Stretch& wanted) {
  const VectorXd x = signal(), whole = how.filter.apply(x);
  const MatrixXd some = dsp::filtered_within(
      how, wanted, 1, [&](Index first, Index count) -> MatrixXd { return x.segment(first, count); });
  const double hz = how.filter.output_rate_hz();
  const auto last = static_cast<double>(whole.size() - 1);
  const auto first = static_cast<Index>(std::ceil(std::max(0.0, wanted.from_s * hz))),
             end = static_cast<Index>(std::floor(std::min(last, wanted.to_s * hz))) + 1;
  REQUIRE(some.rows() == whole.size());
  REQUIRE(some.allFinite());
  return (some.col(0) - whole).segment(first, end - first).cwiseAbs().maxCoeff() / whole.cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("a column of a stretch is the whole one there, bit for bit without a high-pass", "[dsp][filtered_stretch]") {
  for (const dsp::Stretch& wanted : {dsp::Stretch{}, {30.0, 60.0}, {-5.0, 40.0}, {80.0, 500.0}, {50.0, 50.0}}) {
    INFO(wanted.from_s << " to " << wanted.to_s << " s");
    CHECK(difference(prepared(decimation(), {}), wanted) == 0.0);
    CHECK(difference(prepared(dsp::ColumnFilter::taper(rate_hz, {40.0, 60.0}), {}), wanted) == 0.0);
  }
}

TEST_CASE("the last row of a stretch is in it, wherever rounding puts its time", "[dsp][filtered_stretch]") {
  // k / rate * rate is less than k for one row in twenty at 100 Hz; its neighbours make the set of all.
  constexpr double fast_hz = 1000.0, out_hz = 100.0;
  constexpr Index length = 4000;
  dsp::Prepared how;
  how.filter = dsp::ColumnFilter::decimation(fast_hz, {.output_rate_hz = out_hz, .passband_end_hz = 40.0});
  how.intermediate.sample_rate_hz = fast_hz;
  how.intermediate.signals.push_back({"x", "m", VectorXd::Zero(length)});
  how.signals.sample_rate_hz = how.filter.output_rate_hz();
  how.signals.signals.push_back({"x", "m", VectorXd::Zero(length / 10)});
  const VectorXd x = support::gaussian(length, 4, 1.0), whole = how.filter.apply(x);
  const double hz = how.filter.output_rate_hz();
  for (Index row = 40; row < 360; ++row) {
    const double at_s = static_cast<double>(row) / hz;
    const MatrixXd some = dsp::filtered_within(
        how, {at_s, at_s}, 1, [&](Index first, Index count) -> MatrixXd { return x.segment(first, count); });
    INFO("row " << row);
    CHECK(some(row, 0) == whole(row));
  }
}

TEST_CASE("behind a high-pass a column of a stretch is the whole one to a millionth", "[dsp][filtered_stretch]") {
  // As in a run, without 2 / cut-off at the start, where it has not settled, and the filters' reach at the end.
  for (const dsp::Stretch& wanted : {dsp::Stretch{30.0, 60.0}, {5.0, 40.0}, {80.0, 117.0}}) {
    INFO(wanted.from_s << " to " << wanted.to_s << " s");
    CHECK(difference(prepared(decimation(), {0.4}), wanted) < 1e-6);
    CHECK(difference(prepared(decimation(), {0.4, 0.45}), wanted) < 1e-6);
  }
}

TEST_CASE("no more is read than a stretch leans on", "[dsp][filtered_stretch]") {
  const dsp::Prepared how = prepared(decimation(), {0.4});
  const dsp::Stretch wanted{60.0, 70.0}, input_interval = dsp::input_interval(how, wanted);
  CHECK(input_interval.from_s > 40.0);
  CHECK(input_interval.to_s < 80.0);
  (void)dsp::filtered_within(how, wanted, 1, [&](Index first, Index count) -> MatrixXd {
    CHECK(static_cast<double>(first) >= (input_interval.from_s - 2.0 / row_hz) * rate_hz);
    CHECK(static_cast<double>(first + count) <= (input_interval.to_s + 2.0 / row_hz) * rate_hz);
    return MatrixXd::Ones(count, 1);
  });
}

TEST_CASE("an empty stretch wants nothing", "[dsp][filtered_stretch]") {
  const double never = std::numeric_limits<double>::infinity();
  const MatrixXd none = dsp::filtered_within(prepared(decimation(), {0.4}), {never, -never}, 2,
                                             [](Index, Index) -> MatrixXd { throw std::logic_error("nothing"); });
  CHECK(none.cols() == 2);
  CHECK(none.isZero(0.0));
}
