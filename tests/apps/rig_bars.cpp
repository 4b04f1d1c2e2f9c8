// What preparation makes of the rig's sensors, against what the rig truly did.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "dsp/filter/column_filter.hpp"
#include "dsp/filter/decimate.hpp"
#include "dsp/filter/spectral.hpp"
#include "dsp/prepare.hpp"
#include "support/program.hpp"
#include "support/rig.hpp"
#include "support/signals.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 25.6;
const dsp::DecimateOptions to_intermediate{
    .output_rate_hz = 256.0, .passband_end_hz = 30.0, .stopband_start_hz = 226.0};
const dsp::DecimateOptions to_regression{.output_rate_hz = rate_hz, .passband_end_hz = 10.24};
const dsp::SpectralBand band{8.0, 10.24};

sim::Programme shortened(double duration_s) {
  sim::Programme programme = sim::stepped_sine_down();
  programme.duration_s = duration_s;
  std::erase_if(programme.nodes, [&](const auto& node) { return node.t_s >= duration_s; });
  return programme;
}

/// Of v and the second derivative of x, at 25.6 Hz: NMSE within, and over the first and last second.
struct Errors {
  double v_within, v_ends, a_within, a_ends;
};

// Derivatives of an interval cut out of the record, against the truth of the whole, seen through the same filters.
Errors derivative_errors(sim::SensorLevel level, double duration_s, double from_s, double to_s, std::uint64_t seed) {
  const auto record = support::rig_record(sim::qzs_twin("T0"), shortened(duration_s), {.level = level, .seed = seed});
  const VectorXd v =
      dsp::ColumnFilter::taper(rate_hz, band)
          .apply(dsp::ColumnFilter::decimation(support::rig_intermediate_hz, to_regression).apply(record.v));
  const VectorXd a = dsp::ExtendedSpectrum(v, rate_hz).derivative(1, band);

  dsp::Recording cut = record.recording;
  const auto first = static_cast<Index>(from_s * support::rig_intermediate_hz);
  cut.samples =
      record.recording.samples.middleRows(first, static_cast<Index>((to_s - from_s) * support::rig_intermediate_hz))
          .eval();
  cut.bad.clear();
  const auto prepared = dsp::prepare(cut, {.recipe = dsp::Recipe::paper,
                                           .rate_hz = rate_hz,
                                           .cutoff_hz = band.cutoff_hz,
                                           .rolloff_hz = band.rolloff_hz,
                                           .acceleration = dsp::AccelerationSource::displacement});
  const Index n = prepared.signals.num_samples(), begin = static_cast<Index>(from_s * rate_hz), end = 26;
  const auto within = [&](const VectorXd& found, const VectorXd& truth) {
    return support::nmse(found.segment(end, n - 2 * end), truth.segment(begin + end, n - 2 * end));
  };
  const auto ends = [&](const VectorXd& found, const VectorXd& truth) {
    VectorXd both(2 * end), both_true(2 * end);
    both << found.head(end), found.tail(end);
    both_true << truth.segment(begin, end), truth.segment(begin + n - end, end);
    return support::nmse(both, both_true);
  };
  const VectorXd &found_v = prepared.signals.at("v"), &found_a = prepared.signals.at("a");
  return {within(found_v, v), ends(found_v, v), within(found_a, a), ends(found_a, a)};
}

void check_derivatives(double duration_s, double from_s, double to_s, std::uint64_t seed) {
  const Errors ideal = derivative_errors(sim::SensorLevel::ideal, duration_s, from_s, to_s, seed);
  const Errors noise = derivative_errors(sim::SensorLevel::noise, duration_s, from_s, to_s, seed);
  CAPTURE(ideal.v_within, ideal.v_ends, noise.v_within, noise.v_ends, noise.a_within, noise.a_ends);
  for (const double error : {ideal.v_within, ideal.v_ends}) CHECK(error <= 1e-8);
  for (const double error : {noise.v_within, noise.v_ends}) CHECK(error <= 5e-6);
  for (const double error : {noise.a_within, noise.a_ends}) CHECK(error <= 1e-4);
}

/// The record's frames [from_s, to_s) brought down to 25.6 Hz as if there were no others.
class Cut {
 public:
  Cut(double from_s, double to_s)
      : first_(std::llround(from_s * sim::raw_rate_hz)),
        last_(std::llround(to_s * sim::raw_rate_hz)),
        to_intermediate_(sim::raw_rate_hz, sim::num_raw_channels, to_intermediate),
        down_(support::rig_intermediate_hz, sim::num_raw_channels, to_regression) {}
  void push(std::int64_t begin, const dsp::FrameBlock& frames) {
    const std::int64_t from = std::clamp<std::int64_t>(first_ - begin, 0, frames.rows()),
                       to = std::clamp<std::int64_t>(last_ - begin, 0, frames.rows());
    if (from < to) keep(down_.push(to_intermediate_.push(frames.middleRows(from, to - from))));
  }
  const MatrixXd& finish() {
    keep(down_.push(to_intermediate_.finish()));
    keep(down_.finish());
    return rows_;
  }

 private:
  void keep(const dsp::FrameBlock& rows) {
    rows_.conservativeResize(rows_.rows() + rows.rows(), sim::num_raw_channels);
    rows_.bottomRows(rows.rows()) = rows;
  }
  std::int64_t first_, last_;
  dsp::Decimator to_intermediate_, down_;
  MatrixXd rows_;
};

// What the ends of a record cost: the same interval with and without its neighbourhood. Largest of all channels.
double end_error(double duration_s, double from_s, double to_s, std::uint64_t seed) {
  const auto rig = std::make_shared<const sim::QzsRig>(sim::qzs_twin("T0"), shortened(duration_s));
  sim::RawRecorder recorder(rig, duration_s, {.level = sim::SensorLevel::noise, .seed = seed});
  Cut whole(0.0, duration_s), part(from_s, to_s);
  for (std::int64_t begin = 0; begin < recorder.num_frames();) {
    const dsp::FrameBlock frames = recorder.next(1 << 16);
    whole.push(begin, frames);
    part.push(begin, frames);
    begin += frames.rows();
  }
  const MatrixXd found = part.finish();
  const MatrixXd expected = whole.finish().middleRows(static_cast<Index>(from_s * rate_hz), found.rows());
  const Index end = 44;  // 1.7 s
  const MatrixXd error = found - expected;
  double worst = 0.0;
  for (Index c = 0; c < found.cols(); ++c) {
    const double signal = (expected.col(c).array() - expected.col(c).mean()).square().mean();
    const double both = (error.col(c).head(end).squaredNorm() + error.col(c).tail(end).squaredNorm()) / (2.0 * end);
    worst = std::max(worst, std::sqrt(both / signal));
  }
  return worst;
}

}  // namespace

TEST_CASE("derivatives of the rig's displacements agree with its true motion, to the ends", "[apps][rig_bars]") {
  check_derivatives(200.0, 20.0, 180.0, 1);
}

TEST_CASE("derivatives of the whole record agree with the true motion", "[.][study][rig_bars]") {
  for (const std::uint64_t seed : {1, 31, 32, 33, 34, 35}) {
    const Errors ideal = derivative_errors(sim::SensorLevel::ideal, 1720.0, 20.0, 1700.0, seed);
    const Errors noise = derivative_errors(sim::SensorLevel::noise, 1720.0, 20.0, 1700.0, seed);
    const double end = end_error(1720.0, 20.0, 1700.0, seed);
    WARN("seed " << seed << ", within / ends: v ideal " << ideal.v_within << " / " << ideal.v_ends << ", v noise "
                 << noise.v_within << " / " << noise.v_ends << ", a noise " << noise.a_within << " / " << noise.a_ends
                 << "; decimation's ends " << end);
    CHECK(std::max(ideal.v_within, ideal.v_ends) <= 1e-8);
    CHECK(std::max(noise.v_within, noise.v_ends) <= 5e-6);
    CHECK(std::max(noise.a_within, noise.a_ends) <= 1e-4);
    CHECK(end <= 1e-3);
  }
}

TEST_CASE("the ends of a raw record cost a thousandth of its size at most", "[apps][rig_bars]") {
  CHECK(end_error(120.0, 20.0, 100.0, 1) <= 1e-3);
}

TEST_CASE("the whole record shows gains, lags and cut-offs of its sensors, and its power balance closes",
          "[apps][rig_bars]") {
  const support::Scratch folder;
  support::expect(folder,
                  "$ARDENT prep " ARDENT_DATA
                  "/qzs_256.flac -o rig --set prepare.rate_hz=25.6 --set "
                  "prepare.cutoff_hz=10.24 --set prepare.rolloff_hz=8",
                  0, {});
  const auto quality = nlohmann::json::parse(support::bytes_of(folder / "rig/quality.json"));
  const auto sensors = sim::rig_sensors(sim::SensorLevel::full, sim::qzs_twin("T0"));
  REQUIRE(quality["pairs"].size() == 2);
  for (std::size_t body = 0; body < 2; ++body) {
    const auto& pair = quality["pairs"][body];
    const auto &laser = sensors[body], &accelerometer = sensors[body + 2];
    CAPTURE(pair);
    CHECK(std::abs(pair["gain"].get<double>() - accelerometer.gain / laser.gain) <= 5e-4);
    CHECK(std::abs(pair["lag_s"].get<double>() - laser.lag_s) <= 0.15e-3);
    REQUIRE(pair["highpass_hz"].size() == 1);
    CHECK(std::abs(pair["highpass_hz"][0].get<double>() - accelerometer.highpass_hz[0]) <= 0.005);
  }
  CAPTURE(quality["power_check"]);
  for (const char* regime : {"low", "high"}) {
    CHECK(std::abs(quality["power_check"]["raw"][regime].get<double>()) > 0.02);
    CHECK(std::abs(quality["power_check"]["corrected"][regime].get<double>()) <= 2e-3);
  }
}
