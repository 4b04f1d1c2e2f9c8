#include "dsp/filter/decimate.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "dsp/filter/decimate_between.hpp"
#include "dsp/filter/filter_design.hpp"
#include "support/signals.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;
const dsp::DecimateOptions to_intermediate{
    .output_rate_hz = 256.0, .passband_end_hz = 30.0, .stopband_start_hz = 226.0};
const dsp::DecimateOptions to_regression{.output_rate_hz = 25.6, .passband_end_hz = 10.24};

VectorXd tone(Index n, double rate_hz, double f) {
  return VectorXd::NullaryExpr(n,
                               [&](Index i) { return std::sin(two_pi * f * static_cast<double>(i) / rate_hz + 0.3); });
}

double rms(const VectorXd& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(x.size()));
}

dsp::FrameBlock in_blocks(const MatrixXd& samples, double rate_hz, const dsp::DecimateOptions& options, Index block) {
  dsp::Decimator decimator(rate_hz, samples.cols(), options);
  const dsp::FrameBlock frames = samples;
  std::vector<dsp::FrameBlock> parts;
  Index rows = 0;
  for (Index first = 0; first < frames.rows(); first += block)
    parts.push_back(decimator.push(frames.middleRows(first, std::min(block, frames.rows() - first))));
  parts.push_back(decimator.finish());
  for (const auto& part : parts) rows += part.rows();
  dsp::FrameBlock all(rows, samples.cols());
  rows = 0;
  for (const auto& part : parts) {
    all.middleRows(rows, part.rows()) = part;
    rows += part.rows();
  }
  return all;
}

}  // namespace

TEST_CASE("the data sheet meets what was asked, for whole and broken ratios", "[dsp][decimate]") {
  struct Case {
    double input_hz;
    dsp::DecimateOptions options;
  };
  const Case cases[] = {{25600, to_intermediate},
                        {256, to_regression},
                        {25600, to_regression},
                        {10000, {.output_rate_hz = 100, .passband_end_hz = 40}},
                        {51200, {.output_rate_hz = 25600, .passband_end_hz = 10000}},
                        {3200, {.output_rate_hz = 200, .passband_end_hz = 80}},
                        {1000, {.output_rate_hz = 25.6, .passband_end_hz = 10.24}},
                        {610.3515625, {.output_rate_hz = 100, .passband_end_hz = 40}},
                        {997, {.output_rate_hz = 10, .passband_end_hz = 4}},
                        {48000, {.output_rate_hz = 44100, .passband_end_hz = 18000}},
                        {100, {.output_rate_hz = 100, .passband_end_hz = 20}}};
  for (const Case& c : cases) {
    INFO(c.input_hz << " Hz to " << c.options.output_rate_hz);
    const auto sheet = dsp::measure(dsp::design_decimation(c.input_hz, c.options), c.input_hz, c.options);
    CHECK(sheet.passband_ripple_db <= c.options.passband_ripple_db);
    CHECK(sheet.alias_rejection_db >= c.options.stopband_attenuation_db);
    double ratio = 1.0;
    for (const auto& stage : sheet.stages) {
      ratio *= static_cast<double>(stage.down) / stage.up;
      for (Index phase = 0; phase < stage.taps.cols(); ++phase)
        CHECK(stage.taps.col(phase).sum() == Approx(1.0).epsilon(1e-14));
    }
    CHECK(ratio == Approx(c.input_hz / c.options.output_rate_hz).epsilon(1e-9));
  }
}

TEST_CASE("output n is centred on n / output rate: a tone comes out in phase and at its size", "[dsp][decimate]") {
  for (const auto& [input_hz, options] :
       {std::pair{2560.0, dsp::DecimateOptions{.output_rate_hz = 25.6, .passband_end_hz = 10.24}},
        std::pair{1000.0, dsp::DecimateOptions{.output_rate_hz = 30.0, .passband_end_hz = 10.0}}}) {
    const double f = 0.3 * options.output_rate_hz;
    const MatrixXd out = dsp::decimate(tone(static_cast<Index>(40 * input_hz), input_hz, f), input_hz, options);
    REQUIRE(out.rows() == static_cast<Index>((40 * input_hz - 1) * options.output_rate_hz / input_hz) + 1);
    const VectorXd expected = tone(out.rows(), options.output_rate_hz, f);
    // Pass-band ripple of 1e-3 dB is 1.2e-4.
    CHECK((out.col(0) - expected).cwiseAbs().maxCoeff() <= 1.2e-4);
  }
}

TEST_CASE("what comes out is late by a millionth of a second at most", "[dsp][decimate]") {
  // Phase of a tone by least squares, away from the ends.
  for (const auto& [input_hz, options] :
       {std::pair{25600.0, to_intermediate}, std::pair{25600.0, to_regression}, std::pair{256.0, to_regression}}) {
    for (const double f : {0.8, 1.7, 6.0}) {
      const MatrixXd out = dsp::decimate(tone(static_cast<Index>(12 * input_hz), input_hz, f), input_hz, options);
      double sine = 0.0, cosine = 0.0;
      const double rate_hz = options.output_rate_hz;
      const auto first = static_cast<Index>(3 * rate_hz), count = static_cast<Index>(std::round(5 * rate_hz));
      for (Index n = first; n < first + count; ++n) {  // half periods of every tone
        const double angle = two_pi * f * static_cast<double>(n) / rate_hz;
        sine += out(n, 0) * std::sin(angle);
        cosine += out(n, 0) * std::cos(angle);
      }
      const double late_s = (0.3 - std::atan2(cosine, sine)) / (two_pi * f);
      CAPTURE(input_hz, f, late_s);
      CHECK(std::abs(late_s) <= 1e-6);
    }
  }
}

TEST_CASE("every tone that would fold is 120 dB down, by direct convolution too", "[dsp][decimate]") {
  // A second computation: the outputs as plain sums over the cascade's combined impulse response.
  const double input_hz = 2560.0;
  const dsp::DecimateOptions options{.output_rate_hz = 25.6, .passband_end_hz = 10.24};
  const auto stages = dsp::design_decimation(input_hz, options);
  VectorXd combined = VectorXd::Ones(1);
  Index spacing = 1;
  for (const auto& stage : stages) {
    REQUIRE(stage.up == 1);
    VectorXd wider = VectorXd::Zero(combined.size() + spacing * (stage.taps.rows() - 1));
    for (Index j = 0; j < stage.taps.rows(); ++j)
      wider.segment(j * spacing, combined.size()) += stage.taps(j, 0) * combined;
    combined = wider;
    spacing *= stage.down;
  }
  const Index half = (combined.size() - 1) / 2;
  for (const double f : {12.8, 13.5, 15.36, 26.6, 51.3, 100.3, 1234.5}) {
    const Index n = 40000;
    const VectorXd x = tone(n, input_hz, f);
    const MatrixXd out = dsp::decimate(x, input_hz, options);
    const Index middle = out.rows() / 2;
    CHECK(rms(out.col(0).segment(middle - 50, 100)) <= 1e-6 * std::sqrt(0.5));
    CHECK(out(middle, 0) == Approx(combined.dot(x.segment(middle * 100 - half, combined.size()))).margin(1e-13));
  }
}

TEST_CASE("any block size gives the same bits", "[dsp][decimate]") {
  MatrixXd samples(60000, 3);
  for (Index c = 0; c < 3; ++c)
    samples.col(c) = support::gaussian(60000, 7 + static_cast<unsigned>(c)) + tone(60000, 2560.0, 1.7);
  const auto one = in_blocks(samples, 2560.0, {.output_rate_hz = 25.6, .passband_end_hz = 10.24}, samples.rows());
  for (const Index block : {Index{1}, Index{7}, Index{1000}, Index{65536}})
    CHECK(in_blocks(samples, 2560.0, {.output_rate_hz = 25.6, .passband_end_hz = 10.24}, block) == one);
  const dsp::DecimateOptions broken{.output_rate_hz = 44.1, .passband_end_hz = 18.0};
  const auto other = in_blocks(samples, 2560.0, broken, samples.rows());
  for (const Index block : {Index{1}, Index{999}}) CHECK(in_blocks(samples, 2560.0, broken, block) == other);
}

TEST_CASE("outputs that are asked for alone are the same bits, and no more is read than they lean on",
          "[dsp][decimate]") {
  struct Case {
    double input_hz;
    dsp::DecimateOptions options;
  };
  const Case cases[] = {{256, to_regression},
                        {25600, to_regression},
                        {10000, {.output_rate_hz = 7500, .passband_end_hz = 2000}},
                        {100, {.output_rate_hz = 100, .passband_end_hz = 40}}};
  for (const auto& [rate_hz, options] : cases) {
    const Index n = 60'000;
    const MatrixXd samples = (MatrixXd(n, 2) << support::gaussian(n, 5), tone(n, rate_hz, 3.0)).finished();
    const dsp::Decimator decimator(rate_hz, 1, options);
    const dsp::FilterSheet& design = decimator.sheet();
    const MatrixXd whole = dsp::decimate(samples, design);
    const double ratio = rate_hz / options.output_rate_hz;
    const double reach = design.edge_s * rate_hz + 2.0 * ratio;
    const Index rows = whole.rows();
    const Index pairs[][2] = {{0, rows}, {0, rows / 3}, {rows / 3, rows / 2}, {rows / 2, rows}, {rows / 2, rows / 2}};
    for (const auto& [first, end] : pairs) {
      Index least = n, most = 0;
      const auto read = [&](Index from, Index count) -> MatrixXd {
        least = std::min(least, from), most = std::max(most, from + count);
        return samples.middleRows(from, count);
      };
      const MatrixXd some = dsp::decimate_between(first, end, n, 2, read, design);
      INFO(rate_hz << " Hz, outputs " << first << " to " << end << " of " << rows);
      REQUIRE(some.rows() == rows);
      CHECK(some.middleRows(first, end - first) == whole.middleRows(first, end - first));
      const double from = ratio * static_cast<double>(first) - reach, to = ratio * static_cast<double>(end) + reach;
      if (first == end || from < 0.0 || to > static_cast<double>(n)) continue;
      CHECK(static_cast<double>(least) >= from);
      CHECK(static_cast<double>(most) <= to);
    }
  }
}

TEST_CASE("the ends continue the record instead of inventing a step", "[dsp][decimate]") {
  const double input_hz = 256.0;
  const support::SweptHarmonics motion;
  VectorXd x(static_cast<Index>(120 * input_hz));
  for (Index i = 0; i < x.size(); ++i) x(i) = motion.at(static_cast<double>(i) / input_hz).x;
  x += support::gaussian(x.size(), 3, 2e-6);
  const MatrixXd out = dsp::decimate(x, input_hz, to_regression);
  VectorXd error(out.rows());
  for (Index n = 0; n < out.rows(); ++n) error(n) = out(n, 0) - motion.at(static_cast<double>(n) / 25.6).x;
  const Index edge = 44;  // 1.7 s
  const double signal = rms(out.col(0));
  CHECK(rms(error.head(edge)) <= 1e-3 * signal);
  CHECK(rms(error.tail(edge)) <= 1e-3 * signal);
  CHECK(rms(error.segment(edge, error.size() - 2 * edge)) <= 3e-4 * signal);  // the noise within the band
}

TEST_CASE("what cannot be asked of a decimator is refused", "[dsp][decimate]") {
  CHECK_THROWS_AS(dsp::Decimator(100.0, 1, {.output_rate_hz = 200.0, .passband_end_hz = 10.0}), std::invalid_argument);
  CHECK_THROWS_AS(dsp::Decimator(100.0, 1, {.output_rate_hz = 20.0, .passband_end_hz = 10.0}), std::invalid_argument);
  CHECK_THROWS_AS(dsp::Decimator(100.0, 1, {.output_rate_hz = 20.0}), std::invalid_argument);
  CHECK_THROWS_AS(dsp::Decimator(100.0, 0, {.output_rate_hz = 20.0, .passband_end_hz = 8.0}), std::invalid_argument);
  CHECK_THROWS_AS(dsp::Decimator(100.0 * std::numbers::pi, 1, {.output_rate_hz = 20.0, .passband_end_hz = 8.0}),
                  std::invalid_argument);
  CHECK_THROWS_AS(dsp::Decimator(100.0, 1, {.output_rate_hz = 20.0, .passband_end_hz = 8.0, .stopband_start_hz = 7.0}),
                  std::invalid_argument);
  CHECK_THROWS_AS(
      dsp::Decimator(100.0, 1, {.output_rate_hz = 20.0, .passband_end_hz = 8.0, .stopband_attenuation_db = 300.0}),
      std::invalid_argument);
  // Nothing takes long to refuse: these would need tens of millions of coefficients.
  CHECK_FALSE(dsp::is_designable(25600.0, {.output_rate_hz = 31.4159, .passband_end_hz = 5.0}));
  CHECK_FALSE(dsp::is_designable(25600.0, {.output_rate_hz = 25600.0 / 10007, .passband_end_hz = 1.0}));
  CHECK_FALSE(dsp::is_designable(25600.0, {.output_rate_hz = 25.6, .passband_end_hz = 12.7999}));
  CHECK(dsp::is_designable(25600.0, to_regression));
  CHECK_THROWS_AS(dsp::design_decimation(25600.0, {.output_rate_hz = 25600.0 / 10007, .passband_end_hz = 1.0}),
                  std::invalid_argument);
  CHECK_THROWS_WITH(dsp::decimate(VectorXd::Ones(100), 2560.0, {.output_rate_hz = 25.6, .passband_end_hz = 10.24}),
                    Catch::Contains("are the least"));
  CHECK_THROWS_AS(
      dsp::Decimator(100.0, 2, {.output_rate_hz = 20.0, .passband_end_hz = 8.0}).push(dsp::FrameBlock::Zero(4, 3)),
      std::invalid_argument);
}

TEST_CASE("a decimator that is moved goes on where it was", "[dsp][decimate]") {
  dsp::FrameBlock frames(20000, 2);
  frames.col(0) = support::gaussian(20000, 1);
  frames.col(1) = support::gaussian(20000, 2);
  dsp::Decimator first(2560.0, 2, to_intermediate), other(2560.0, 1, to_intermediate);
  const dsp::FrameBlock head = first.push(frames.topRows(7000));
  other = std::move(first);
  dsp::Decimator last(std::move(other));
  dsp::FrameBlock whole(dsp::decimate(frames, 2560.0, to_intermediate).rows(), 2);
  dsp::FrameBlock wide(13000, 3);
  wide << frames.bottomRows(13000), Eigen::VectorXd::Zero(13000);
  const dsp::FrameBlock middle = last.push(wide.leftCols<2>()), tail = last.finish();
  whole << head, middle, tail;
  CHECK(whole == dsp::FrameBlock(dsp::decimate(frames, 2560.0, to_intermediate)));
  CHECK_THROWS_AS(last.push(frames.leftCols<1>()), std::invalid_argument);
}
