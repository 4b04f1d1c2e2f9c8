#include "ident/validate/regressor_noise.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <utility>

#include "dsp/filter/spectral.hpp"
#include "dsp/prepare.hpp"
#include "ident/identify.hpp"
#include "ident/sensors/channel_noise.hpp"
#include "support/oscillator.hpp"
#include "support/signals.hpp"

namespace test_validate_regressor_noise {

using Catch::Detail::Approx;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 200.0;

/// The displacement and the force of a driven oscillator, with white noise on the former.
dsp::Recording displacement_only(double noise_std, std::uint32_t seed) {
  static const sim::Experiment experiment =
      sim::make_experiment(sim::Linear{.omega_n = 9.0, .zeta = 0.05, .ratio = 0.8});
  static const dsp::Motion motion = support::motion_of(experiment, 120.0, rate_hz);
  dsp::Recording recording{.name = "bench", .sample_rate_hz = rate_hz};
  recording.channels = {{.name = "laser", .role = dsp::Role::x, .unit = "m"},
                        {.name = "cell", .role = dsp::Role::f, .unit = "N"}};
  recording.samples.resize(motion.num_samples(), 2);
  recording.samples.col(0) = motion.at("x") + support::gaussian(motion.num_samples(), seed, noise_std);
  recording.samples.col(1) = motion.at("f");
  return recording;
}

ident::JudgedFit fit_of(const dsp::Recording& recording, double cutoff_hz,
                        const std::vector<std::string>& terms = {"x", "v", "f"}) {
  const auto record = ident::Record{.prepared = dsp::prepare(recording, {.cutoff_hz = cutoff_hz})};
  const auto ranges =
      ident::identify(record, {.order = 0, .terms = terms}, {.methods = {ident::OlsOptions{}}, .free_run = false});
  return ranges.at(0).fits.at(0);
}

}  // namespace

TEST_CASE("white noise beside lines and a falling spectrum has the density it was given", "[ident][regressor_noise]") {
  const double std = 0.03;
  VectorXd signal = support::gaussian(20'000, 1, std);
  for (Index i = 0; i < signal.size(); ++i) {
    const double t = static_cast<double>(i) / rate_hz;
    for (int k = 1; k < 30; ++k) signal(i) += std::cos(2.0 * std::numbers::pi * 3.1 * k * t) / (k * k);
  }
  // Median of some 1500 ordinates, the least of four: a few per cent.
  const ident::NoiseDensity found = ident::noise_density(signal, rate_hz, 20.0, 90.0);
  CHECK(found.value == Approx(2.0 * std * std / rate_hz).epsilon(0.1));
  CHECK_FALSE(found.is_bound);
  // Behind somebody's low-pass there is no floor to see: what is nearest to the band is a bound.
  const VectorXd smooth = dsp::ExtendedSpectrum(signal, rate_hz).filtered([](double f) { return std::exp(-f / 8.0); });
  const ident::NoiseDensity bound = ident::noise_density(smooth, rate_hz, 20.0, 90.0);
  CHECK(bound.is_bound);
  CHECK(bound.value > 2.0 * std * std / rate_hz * std::exp(-2.0 * 37.5 / 8.0));
}

TEST_CASE("noise of a displacement biases stiffness and damping by as much as is said", "[ident][regressor_noise]") {
  const ident::JudgedFit exact = fit_of(displacement_only(0.0, 1), 15.0);
  const double level = 0.02 * std::sqrt(displacement_only(0.0, 1).samples.col(0).squaredNorm() / (120.0 * rate_hz));
  constexpr int draws = 12;
  VectorXd bias = VectorXd::Zero(3), said = bias, residual = VectorXd::Zero(2);
  for (int draw = 0; draw < draws; ++draw) {
    const ident::JudgedFit fit = fit_of(displacement_only(level, 100 + static_cast<std::uint32_t>(draw)), 15.0);
    for (Index i = 0; i < 3; ++i)
      bias(i) +=
          (fit.model.terms[static_cast<std::size_t>(i)].mean - exact.model.terms[static_cast<std::size_t>(i)].mean) /
          draws;
    said += fit.noise.bias / draws;
    residual += Eigen::Vector2d(fit.noise.residual_power, std::pow(fit.noise.residual_std, 2)) / draws;
  }
  // What is said is of first order in the noise, and the draws scatter: a sixth of the greatest.
  CHECK(std::abs(bias(0)) > 0.01 * std::abs(exact.model.terms[0].mean));
  for (Index i = 0; i < 3; ++i) {
    CAPTURE(i, bias(i), said(i));
    CHECK(std::abs(said(i) - bias(i)) <
          0.2 * std::abs(bias(i)) + 0.002 * std::abs(exact.model.terms[static_cast<std::size_t>(i)].mean));
  }
  CHECK(residual(1) == Approx(residual(0)).epsilon(0.15));
  CHECK(exact.noise.bias.cwiseAbs().maxCoeff() < 1e-3 * said.cwiseAbs().maxCoeff());
}

TEST_CASE("what an equation lacks is seen at the motion's frequencies under noise of a wide band",
          "[ident][regressor_noise]") {
  // Noise of x, derived twice up to 40 Hz, about a motion at 1.1 Hz.
  const double level = 0.002 * std::sqrt(displacement_only(0.0, 1).samples.col(0).squaredNorm() / (120.0 * rate_hz));
  const dsp::Recording recording = displacement_only(level, 3);
  const ident::RegressorNoise of_all = fit_of(recording, 40.0).noise,
                              of_some = fit_of(recording, 40.0, {"x", "f"}).noise;
  CHECK(of_all.needed_hz < 10.0);
  CHECK(std::pow(of_all.residual_std, 2) == Approx(of_all.residual_power).epsilon(0.15));
  CHECK(std::pow(of_some.residual_std, 2) == Approx(of_some.residual_power).epsilon(0.15));
  CHECK(of_all.motion_power < 2.0 * std::pow(of_all.motion_std, 2));
  CHECK(of_some.motion_power > 10.0 * std::pow(of_some.motion_std, 2));
}

TEST_CASE("the difference of two accelerometers has the noise of both, and shares that of one",
          "[ident][regressor_noise]") {
  const sim::Coulomb p{.c = 1.0, .k = 400.0, .c_f = 0.0, .force_n = 100.0, .ratio = 0.8};
  const dsp::Motion motion = support::friction_on_the_ground(p, 60.0, rate_hz);
  const std::vector<std::pair<std::string, double>> channels{{"r", 1e-4}, {"y", 2e-4}, {"ddr", 0.3}, {"ddy", 0.2}};
  dsp::Recording recording{.name = "rig", .sample_rate_hz = rate_hz};
  recording.samples.resize(motion.num_samples(), 4);
  std::uint32_t seed = 7;
  for (const auto& [name, std] : channels) {
    recording.samples.col(std::ssize(recording.channels)) =
        motion.at(name) + support::gaussian(motion.num_samples(), seed++, std);
    const dsp::SignalInfo& info = *dsp::find_signal(name);
    recording.channels.push_back({.name = name, .role = info.role, .unit = std::string(info.unit)});
  }
  const dsp::Prepared prepared = dsp::prepare(recording, {.cutoff_hz = 20.0, .rolloff_hz = 16.0, .equalise = false});
  const ident::ChannelNoise noise(prepared, "a");
  const double within = 18.0 / (0.5 * rate_hz);  // of a channel's variance
  // The least of four medians: a tenth below on average.
  CHECK(noise.covariance("a", "a") == Approx(within * (0.3 * 0.3 + 0.2 * 0.2)).epsilon(0.2));
  CHECK(noise.covariance("a", "ddr") == Approx(-within * 0.3 * 0.3).epsilon(0.2));
  CHECK(noise.covariance("x", "x") == Approx(within * (1e-8 + 4e-8)).epsilon(0.2));
  CHECK(noise.covariance("x", "y") == Approx(within * 4e-8).epsilon(0.2));
  CHECK(noise.covariance("x", "a") == 0.0);
  // Of a derivative over the band: (2 pi f)^2 on average.
  CHECK(noise.covariance("v", "v") ==
        Approx(noise.covariance("x", "x") * std::pow(2.0 * std::numbers::pi * 18.0, 2) / 3.0).epsilon(1e-9));
  CHECK(noise.covariance("x", "v") == 0.0);
}

TEST_CASE("what is integrated has the noise of its accelerometer, integrated as it is", "[ident][regressor_noise]") {
  constexpr double seconds = 400.0, from_hz = 0.8;
  const auto n = static_cast<Eigen::Index>(seconds * rate_hz);
  // A motion and noise, and the noise alone: what the latter becomes is measured.
  const auto prepared = [&](double motion, dsp::Role role = dsp::Role::a) {
    dsp::Recording recording{.name = "mass", .sample_rate_hz = rate_hz};
    recording.channels = {{.name = "a", .role = role, .unit = "m/s^2"}};
    recording.samples = support::gaussian(n, 11, 0.3);
    for (Eigen::Index i = 0; i < n; ++i)
      recording.samples(i, 0) += motion * std::sin(2.0 * std::numbers::pi * 2.0 * static_cast<double>(i) / rate_hz);
    return dsp::prepare(recording, {.cutoff_hz = 20.0, .rolloff_hz = 16.0, .integrate_from_hz = from_hz});
  };
  const dsp::Prepared of_noise = prepared(0.0);
  const ident::ChannelNoise noise(prepared(50.0), "a");
  const Eigen::Index edge = of_noise.signals.edge_samples, rows = of_noise.signals.num_samples() - 2 * edge;
  CHECK(static_cast<double>(edge) >= 2.0 / from_hz * of_noise.signals.sample_rate_hz);
  // Of a displacement half lies within 0.4 Hz, so that 400 s know its variance to 0.12; 3 deviations. Of the density,
  // the least of four medians, a tenth below on average.
  const auto mean = [&](const char* one, const char* other) {
    return of_noise.signals.at(one).segment(edge, rows).dot(of_noise.signals.at(other).segment(edge, rows)) /
           static_cast<double>(rows);
  };
  CHECK(noise.covariance("x", "x") == Approx(mean("x", "x")).epsilon(0.4));
  CHECK(noise.covariance("v", "v") == Approx(mean("v", "v")).epsilon(0.3));
  CHECK(noise.covariance("x", "a") == Approx(mean("x", "a")).epsilon(0.3));
  CHECK(noise.covariance("x", "a") == Approx(-noise.covariance("v", "v")).epsilon(1e-12));
  CHECK(noise.covariance("a", "a") == Approx(mean("a", "a")).epsilon(0.2));
  const ident::ChannelNoise of_payload(prepared(50.0, dsp::Role::ddy), "a");  // without a base the same
  CHECK(of_payload.covariance("x", "x") == Approx(noise.covariance("x", "x")).epsilon(1e-9));
}

TEST_CASE("above the frequencies of the motion the target is noise", "[ident][regressor_noise]") {
  const double level = 0.02 * std::sqrt(displacement_only(0.0, 1).samples.col(0).squaredNorm() / (120.0 * rate_hz));
  const ident::JudgedFit fit = fit_of(displacement_only(level, 5), 30.0);
  CHECK(fit.noise.needed_hz > 1.0);  // it moves at 1.15 Hz
  CHECK(fit.noise.needed_hz < 5.0);
  CHECK(fit.noise.band_hz > 20.0);
}

TEST_CASE("noise of a derived speed, in units of the displacement that it stands for", "[ident][regressor_noise]") {
  const double rms = std::sqrt(displacement_only(0.0, 1).samples.col(0).squaredNorm() / (120.0 * rate_hz));
  const double level = 0.02 * rms, omega = 7.2;  // that of the force
  const ident::JudgedFit fit = fit_of(displacement_only(level, 6), 15.0);
  // Density 2 s^2 / rate, times (2 pi f)^2, up to the band's end; the columns' band rolls off before it.
  const double to_hz = fit.noise.band_hz;
  const double of_v = std::sqrt(2.0 / rate_hz * std::pow(to_hz, 3) / 3.0) * 2.0 * std::numbers::pi * level;
  CHECK(fit.noise.v_as_x_std < 1.1 * of_v / omega);
  CHECK(fit.noise.v_as_x_std > 0.6 * of_v / omega);
  CHECK(fit.noise.v_as_x_std > 3.0 * fit.noise.x_std);
}

}  // namespace test_validate_regressor_noise
