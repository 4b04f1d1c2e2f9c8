#include "ident/validate/predict.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "dsp/prepare.hpp"
#include "ident/sensors/channel_noise.hpp"
#include "support/labelled_oscillator.hpp"
#include "support/random.hpp"

using Eigen::Index;
using Eigen::VectorXd;

namespace {

ident::Model model_of(const std::vector<std::pair<std::string, double>>& terms) {
  ident::Model model;
  model.target = "a";
  for (const auto& [name, mean] : terms) model.terms.push_back({.name = name, .mean = mean});
  return model;
}

ident::Record record_of(const dsp::Motion& motion, const std::vector<std::string>& names, double cutoff_hz) {
  return {.prepared = dsp::prepare(support::recorded(motion, names, 0.0, 1), {.cutoff_hz = cutoff_hz})};
}

}  // namespace

TEST_CASE("the noise of x is what of its channel's is within the band", "[ident][predict]") {
  constexpr double rate_hz = 100.0;
  VectorXd motion(8000);
  for (Index i = 0; i < motion.size(); ++i) motion(i) = std::cos(0.1 * static_cast<double>(i));
  for (const double noise_std : {1e-2, 1e-4}) {
    dsp::Recording recording{.name = "bench", .sample_rate_hz = rate_hz};
    recording.channels = {{.name = "laser", .role = dsp::Role::x, .unit = "m"}};
    recording.samples = motion + noise_std * support::gaussian(motion.size(), 1, 3);
    const dsp::Prepared prepared = dsp::prepare(recording, {.cutoff_hz = 10.0, .rolloff_hz = 8.0});
    // Of 50 Hz the band leaves 9; the median of some 600 ordinates in each of four parts knows it to a twentieth.
    const double told = std::sqrt(ident::ChannelNoise(prepared, "x").covariance("x", "x"));
    CHECK(told == Approx(noise_std * std::sqrt(9.0 / 50.0)).epsilon(0.07));
    const dsp::Prepared exact =
        dsp::prepare({.name = "bench", .sample_rate_hz = rate_hz, .channels = recording.channels, .samples = motion},
                     {.cutoff_hz = 10.0, .rolloff_hz = 8.0});
    const VectorXd left = prepared.signals.at("x") - exact.signals.at("x");
    // What is there, in a band of 18 independent values a second.
    CHECK(left.norm() / std::sqrt(8000.0) == Approx(told).epsilon(0.1));
  }
}

TEST_CASE("a prediction begins again where the free run of a verdict does, and so does what it must beat",
          "[ident][predict]") {
  // Ueda's oscillator, whose runs part tenfold in some 22 s.
  support::Oscillator p{.c = 0.05, .k3 = 1.0, .force_gain = 7.5, .x0 = 2.5, .amplitude = 3.0, .omega = 1.0};
  p.drive.tones = {{1.0, 1.0, 0.5 * std::numbers::pi, 0.0}};
  const auto record = record_of(support::motion_of(p, 300.0, 20.0), {"x", "f"}, 4.0);
  const auto off = model_of({{"v", -0.05}, {"x^3", -1.001}, {"f", 7.5}});
  const auto prediction = ident::predict(off, off, record);
  CHECK(prediction.nmse.value < 0.02);
  CHECK(prediction.linear.value == prediction.nmse.value);
  CHECK(prediction.num_restarts > 0);
  CHECK(prediction.unaided.value >
        10.0 * prediction.nmse.value);  // on its own it is soon somewhere else in the attractor
}

TEST_CASE("a prediction of a motion that nothing holds in phase is one run", "[ident][predict]") {
  const double omega = 2.0 * std::numbers::pi;
  const support::Oscillator p{.k = omega * omega, .x0 = 1.0, .amplitude = 1.0, .omega = omega};
  const auto record = record_of(support::motion_of(p, 20.0, 50.0), {"x"}, 10.0);
  const auto prediction = ident::predict(model_of({{"x", -1.01 * omega * omega}}), {}, record);
  // At the end of 20 s it has turned by 0.63: of an angle that grows, a third of its square on average, less what the
  // sine of half of it is less than that, 0.04.
  CHECK(prediction.nmse.value == Approx(std::pow(0.005 * omega * 20.0, 2) / 3.0).epsilon(0.15));
  CHECK(prediction.num_restarts == 0);
  CHECK(prediction.unaided.value == prediction.nmse.value);
}

TEST_CASE("a prediction says where a recording goes beyond what was fitted", "[ident][predict]") {
  const double omega = 2.0 * std::numbers::pi;
  const support::Oscillator p{.k = omega * omega, .x0 = 1.0, .amplitude = 1.0, .omega = omega};
  const auto record = record_of(support::motion_of(p, 20.0, 50.0), {"x"}, 10.0);
  auto model = model_of({{"x", -omega * omega}});
  const double half = std::sqrt(0.5);  // a sine is beyond 0.71 of its amplitude for half of the time
  model.extents = {{"x", -half, half}, {"v", -7.0, 7.0}};
  CHECK_THAT(ident::predict(model, {}, record).remark,
             Catch::Contains("beyond the fitted range: x in 5") &&
                 Catch::Contains("(-1 to 1 m here, -0.707 to 0.707 in the fit"));
  model.extents.front() = {"x", -1.1, 1.1};
  CHECK_THAT(ident::predict(model, {}, record).remark, !Catch::Contains("beyond"));
}
