#include "dsp/regimes/steady_steps.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <random>

namespace test_regimes_steady_steps {

namespace {

using Eigen::Index;
constexpr double two_pi = 6.283185307179586, k = 50.0, c = 2.0;

/// One setting of the drive: base amplitude and fraction of second harmonic.
struct Setting {
  double frequency_hz = 0.0, amplitude_m = 0.0, second = 0.0, duration_s = 12.0;
};

std::complex<double> linear(double f) {
  const double w = two_pi * f;
  return w * w / std::complex<double>(k - w * w, c * w);
}

/// A linear base-excited oscillator in its steady state at every setting, with transitions of 1.5 s between them.
dsp::Motion stepped(const std::vector<Setting>& settings, double noise_m = 0.0, double rate_hz = 25.6) {
  double duration_s = 0.0;
  for (const Setting& s : settings) duration_s += s.duration_s;
  const auto n = static_cast<Index>(duration_s * rate_hz);
  Eigen::VectorXd r(n), x(n);
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 1.0);
  double phase = 0.0, begin_s = 0.0;
  std::size_t here = 0;
  for (Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / rate_hz;
    if (t >= begin_s + settings[here].duration_s && here + 1 < settings.size()) begin_s += settings[here++].duration_s;
    const Setting &now = settings[here], &last = settings[here > 0 ? here - 1 : 0];
    const double u = std::min((t - begin_s) / 1.5, 1.0), fraction = u * u * (3.0 - 2.0 * u);
    const auto mix = [&](double Setting::*field) { return last.*field + fraction * (now.*field - last.*field); };
    const double f = mix(&Setting::frequency_hz), a = mix(&Setting::amplitude_m), second = mix(&Setting::second);
    phase += f / rate_hz;
    const std::complex<double> turn = std::polar(1.0, two_pi * phase);
    r[i] = a * (turn + second * turn * turn).real() + noise_m * normal(random);
    x[i] = a * (linear(f) * turn + second * linear(2.0 * f) * turn * turn).real() + noise_m * normal(random);
  }
  dsp::Motion motion;
  motion.sample_rate_hz = rate_hz;
  motion.signals = {{"x", "m", x}, {"r", "m", r}, {"y", "m", x + r}};
  motion.excluded.assign(static_cast<std::size_t>(n), 0);
  return motion;
}

/// Three iterations at each frequency, from a drive 4 % off and with 1.2 % of a second harmonic.
std::vector<Setting> ladder(const std::vector<double>& frequencies_hz) {
  std::vector<Setting> settings;
  for (const double f : frequencies_hz)
    for (const double residue : {1.0, 0.3, 0.0})
      settings.push_back({f, 4e-3 * (1.0 + 0.04 * residue), 0.012 * residue, 12.0});
  return settings;
}

}  // namespace

TEST_CASE("the end result of every step is the closed form's, iterations before it are distinguished from it",
          "[dsp][steady_steps]") {
  const std::vector<double> frequencies{1.60, 1.59, 1.58, 1.50, 1.40, 1.20};
  for (const double noise_m : {0.0, 4e-6, 15e-6}) {
    const auto steps = dsp::find_steady_steps(stepped(ladder(frequencies), noise_m));
    std::vector<dsp::SteadyStep> finals;
    int iterations = 0;
    for (const auto& step : steps) {
      iterations += step.tag == dsp::StepTag::iteration;
      if (step.tag == dsp::StepTag::final) finals.push_back(step);
    }
    INFO("noise " << noise_m);
    REQUIRE(finals.size() == frequencies.size());
    CHECK(iterations >= 12);  // windows that straddle a transition may be one more
    for (std::size_t i = 0; i < finals.size(); ++i) {
      const auto& step = finals[i];
      // Some 200 samples each: sqrt(2 / 200) of the noise; and what a window's tolerance hides of a transition.
      const double tolerance_m = 0.5 * noise_m + 2e-5 * 4e-3 * 100.0;
      CHECK(step.frequency_hz == Approx(frequencies[i]).epsilon(2e-4));
      CHECK(step.drive == Approx(4e-3).margin(tolerance_m));
      CHECK(step.x_m == Approx(4e-3 * std::abs(linear(frequencies[i]))).epsilon(4e-3).margin(tolerance_m));
      CHECK(step.y_m == Approx(4e-3 * std::abs(1.0 + linear(frequencies[i]))).epsilon(4e-3).margin(tolerance_m));
      CHECK(step.phase_rad == Approx(std::arg(linear(frequencies[i]))).margin(0.01));
      CHECK(step.direction == -1);
      CHECK(!step.locked);
      CHECK(!step.stops);
      CHECK(step.from_s > 36.0 * static_cast<double>(i) + 24.0);
      CHECK(step.to_s < 36.0 * static_cast<double>(i + 1) + 1.0);
    }
  }
}

TEST_CASE("settings that are no end result say why", "[dsp][steady_steps]") {
  std::vector<Setting> settings{{1.2, 4e-3}, {1.3, 4e-3}, {1.4, 4.2e-3}, {1.5, 4e-3, 0.02}, {1.6, 4e-3}, {1.7, 4e-3}};
  auto motion = stepped(settings);
  for (Index i = 0; i < motion.num_samples(); ++i) {
    const double t = static_cast<double>(i) / motion.sample_rate_hz;
    if (t >= 56.0 && t < 57.0) motion.excluded[static_cast<std::size_t>(i)] = 1;
    // The last response dies out from twice its size.
    if (t >= 60.0) motion.signals[0].values[i] *= 1.0 + std::exp(-(t - 60.0) / 8.0);
  }
  const auto steps = dsp::find_steady_steps(motion);
  REQUIRE(steps.size() == 6);
  const dsp::StepTag expected[] = {dsp::StepTag::final,     dsp::StepTag::final,     dsp::StepTag::off_amplitude,
                                   dsp::StepTag::distorted, dsp::StepTag::disturbed, dsp::StepTag::unsettled};
  for (std::size_t i = 0; i < 6; ++i) {
    INFO(i);
    CHECK(to_string(steps[i].tag) == to_string(expected[i]));
    CHECK(steps[i].direction == 1);
  }
}

TEST_CASE("a payload that does not move is locked, one that rests in every period stops", "[dsp][steady_steps]") {
  auto motion = stepped({{1.2, 4e-3}, {1.1, 4e-3}, {1.0, 4e-3}});
  auto& x = motion.signals[0].values;
  for (Index i = 0; i < motion.num_samples(); ++i) {
    const double t = static_cast<double>(i) / motion.sample_rate_hz;
    if (t >= 24.0)
      x[i] = 1e-3;
    else if (t >= 12.0)
      x[i] = 8e-3 * std::clamp(1.5 * std::sin(two_pi * 1.1 * t), -1.0, 1.0);  // at rest for 46 %
  }
  const auto steps = dsp::find_steady_steps(motion);
  REQUIRE(steps.size() == 3);
  CHECK(!steps[0].stops);
  CHECK(steps[1].stops);
  CHECK(!steps[1].locked);
  CHECK(steps[2].locked);
  CHECK(std::isnan(steps[2].phase_rad));
}

TEST_CASE("what is no stepped sine has no steps", "[dsp][steady_steps]") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, 1e-3);
  dsp::Motion motion = stepped({{1.2, 4e-3, 0.0, 60.0}});
  CHECK(dsp::find_steady_steps(motion).empty());  // one tone
  for (auto& signal : motion.signals)
    for (double& value : signal.values) value = normal(random);
  CHECK(dsp::find_steady_steps(motion).empty());
  motion.signals.erase(motion.signals.begin() + 1);
  CHECK(dsp::find_steady_steps(motion).empty());  // nothing that drives
  motion.signals.clear();
  CHECK_THROWS_AS(dsp::find_steady_steps(motion), std::invalid_argument);
}

}  // namespace test_regimes_steady_steps
