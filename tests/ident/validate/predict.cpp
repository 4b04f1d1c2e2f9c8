#include "ident/validate/predict.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "dsp/prepare.hpp"
#include "ident/sensors/channel_noise.hpp"
#include "support/random.hpp"

using Eigen::Index;
using Eigen::VectorXd;

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
    const VectorXd left =
        prepared.signals.at("x") -
        dsp::prepare({.name = "bench", .sample_rate_hz = rate_hz, .channels = recording.channels, .samples = motion},
                     {.cutoff_hz = 10.0, .rolloff_hz = 8.0})
            .signals.at("x");
    // What is there, in a band of 18 independent values a second.
    CHECK(left.norm() / std::sqrt(8000.0) == Approx(told).epsilon(0.1));
  }
}
