#include "ident/equation/absolute_gains.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "ident/identify.hpp"
#include "support/signals.hpp"

namespace test_sensors_absolute_gains {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 256.0;

/// A payload on a fixed base under a force, its displacement and acceleration measured: f = a + 0.8 v + 50 x + 9e4 x^3
/// + friction sgn(v), with a little white noise in f so that there are standard deviations.
dsp::Recording recording(double displacement_gain, double acceleration_gain, double force_gain, double friction = 0.3) {
  const auto n = static_cast<Index>(120 * rate_hz);
  const support::SweptHarmonics motion;
  const VectorXd noise = support::gaussian(n, 5, 1e-3);
  dsp::Recording made{.name = "bench", .sample_rate_hz = rate_hz};
  made.channels = {{.name = "laser", .role = dsp::Role::y, .unit = "m", .sensitivity_uncertainty = 0.005},
                   {.name = "accelerometer", .role = dsp::Role::ddy, .unit = "m/s^2", .sensitivity_uncertainty = 0.02},
                   {.name = "cell", .role = dsp::Role::f, .unit = "N", .sensitivity_uncertainty = 0.03}};
  made.samples.resize(n, 3);
  for (Index i = 0; i < n; ++i) {
    const auto p = motion.at(static_cast<double>(i) / rate_hz);
    const double f =
        p.a + 0.8 * p.v + 50.0 * p.x + 9e4 * std::pow(p.x, 3) + friction * std::copysign(1.0, p.v) + noise(i);
    made.samples.row(i) << displacement_gain * p.x, acceleration_gain * p.a, force_gain * f;
  }
  return made;
}

ident::Model model_of(const dsp::Recording& recording, dsp::PrepareOptions options,
                      std::vector<std::string> terms = {"x", "v", "x^3", "sgn(v)", "f"}) {
  options.rate_hz = 25.6;
  options.cutoff_hz = 10.24;
  options.rolloff_hz = 8.0;
  const ident::LibraryOptions library{.order = 0, .terms = std::move(terms)};
  auto results = ident::identify({.prepared = dsp::prepare(recording, options)}, library,
                                 {.methods = {ident::OlsOptions{}}, .free_run = false});
  return results.at(0).fits.at(0).model;
}

using Exponents = std::map<std::string, double>;

Exponents exponents_of(const ident::Model& model, const std::string& term) {
  for (const ident::ModelTerm& known : model.terms)
    if (known.name == term) return {known.gain_exponents.begin(), known.gain_exponents.end()};
  throw std::out_of_range(term);
}

}  // namespace

TEST_CASE("a coefficient moves with the gain of all displacements, of all accelerations and of the force as stated",
          "[ident][absolute_gains]") {
  const double e = 1e-3;
  for (const bool equalised : {false, true}) {
    const dsp::PrepareOptions options{.equalise = equalised};
    // Where a and v are of two scales their switches are not where v's jump of slope would be that of a: none here.
    const double friction = equalised ? 0.3 : 0.0;
    std::vector<std::string> terms{"x", "v", "x^3", "f"};
    if (equalised) terms.emplace_back("sgn(v)");
    const ident::Model model = model_of(recording(1.0, 1.0, 1.0, friction), options, terms);
    REQUIRE(model.terms.size() == terms.size());
    // What is recorded too small by e is to be raised by it.
    const auto moved = [&](double d, double a, double f) {
      return model_of(recording(1.0 - d, 1.0 - a, 1.0 - f, friction), options, terms);
    };
    const std::map<std::string, ident::Model> with{{"displacements", equalised ? moved(e, e, 0.0) : moved(e, 0.0, 0.0)},
                                                   {"accelerations", moved(0.0, e, 0.0)},
                                                   {"f", moved(0.0, 0.0, e)}};
    for (const auto& [gain, other] : with)
      for (std::size_t j = 0; j < model.terms.size(); ++j) {
        const ident::ModelTerm& term = model.terms[j];
        Exponents exponents = exponents_of(model, term.name);
        INFO(gain << " " << term.name << (equalised ? ", sensors agreeing" : ""));
        const double in_si = other.terms.at(j).mean * std::pow(1.0 + e, exponents[gain]);
        // The record with e is fitted in its own units: in the true ones, it is the same equation. e^2 by the powers
        // of 1 - e and 1 / (1 + e), and where sensors agree a tenth of e by noise in their ratio.
        CHECK(in_si == Approx(term.mean).epsilon((equalised ? 0.1 : 0.01) * e));
      }
  }
}

TEST_CASE("powers of gains follow from a term's degree, of its target and of what its signals rest on",
          "[ident][absolute_gains]") {
  const ident::Model apart = model_of(recording(1.0, 1.0, 1.0), {.equalise = false});
  CHECK(exponents_of(apart, "x^3") == Exponents{{"displacements", -3.0}, {"accelerations", 1.0}});
  CHECK(exponents_of(apart, "v") == Exponents{{"displacements", -1.0}, {"accelerations", 1.0}});
  CHECK(exponents_of(apart, "sgn(v)") == Exponents{{"accelerations", 1.0}});
  CHECK(exponents_of(apart, "f") == Exponents{{"accelerations", 1.0}, {"f", -1.0}});
  // Brought to agree the laser is believed in scale: both go with it.
  const ident::Model together = model_of(recording(1.0, 1.0, 1.0), {});
  CHECK(exponents_of(together, "x") == Exponents{});
  CHECK(exponents_of(together, "v") == Exponents{});
  CHECK(exponents_of(together, "x^3") == Exponents{{"displacements", -2.0}});
  CHECK(exponents_of(together, "f") == Exponents{{"displacements", 1.0}, {"f", -1.0}});
  const ident::Model computed =
      model_of(recording(1.0, 1.0, 1.0), {.acceleration = dsp::AccelerationSource::displacement, .equalise = false});
  CHECK(exponents_of(computed, "x^3") == Exponents{{"displacements", -2.0}});
  const ident::Model by_accelerometer =
      model_of(recording(1.0, 1.0, 1.0), {.scale = dsp::ScaleReference::accelerometer});
  CHECK(exponents_of(by_accelerometer, "x^3") == Exponents{{"accelerations", -2.0}});
}

TEST_CASE("calibrations are stated beside the standard deviations, which do not change with them",
          "[ident][absolute_gains]") {
  dsp::Recording made = recording(1.0, 1.0, 1.0);
  const ident::Model model = model_of(made, {.equalise = false});
  using Calibration = std::vector<std::pair<std::string, double>>;
  CHECK(model.calibration == Calibration{{"displacements", 0.005}, {"accelerations", 0.02}, {"f", 0.03}});
  for (dsp::Channel& channel : made.channels) channel.sensitivity_uncertainty *= 10.0;
  const ident::Model rough = model_of(made, {.equalise = false});
  CHECK(rough.calibration.front().second == Approx(0.05));
  for (std::size_t j = 0; j < model.terms.size(); ++j) CHECK(rough.terms[j].std == model.terms[j].std);
  made.channels[2].calibrated = false;
  CHECK(model_of(made, {}).calibration.empty());
}

TEST_CASE("a gain that cancels is no calibration of the equation", "[ident][absolute_gains]") {
  // x and v are integrals of the only sensor: its gain is on both sides of a linear equation.
  dsp::Recording made = recording(1.0, 1.0, 1.0);
  made.channels = {made.channels[1]};
  made.samples = made.samples.col(1).eval();
  const ident::Model model = model_of(made, {}, {"x", "v", "x^3"});
  CHECK(exponents_of(model, "x") == Exponents{});
  CHECK(exponents_of(model, "v") == Exponents{});
  CHECK(exponents_of(model, "x^3") == Exponents{{"accelerations", -2.0}});
}

TEST_CASE("a term without a degree goes with the nearest multiple of it", "[ident][absolute_gains]") {
  dsp::Motion motion{.sample_rate_hz = 1.0};
  motion.signals = {{"x", "m", VectorXd::LinSpaced(101, -1e-3, 1e-3)}, {"v", "m/s", VectorXd::LinSpaced(101, -1, 1)}};
  const ident::AbsoluteGain gain{"displacements", 0.01, {"x", "v"}};
  CHECK(ident::gain_exponent(ident::Expression("sin(x)"), "a", gain, motion) == Approx(-1.0).epsilon(1e-6));  // small x
  CHECK(ident::gain_exponent(ident::Expression("abs(v)*x"), "a", gain, motion) == -2.0);
  CHECK(ident::gain_exponent(ident::Expression("1"), "a", gain, motion) == 0.0);
  CHECK(ident::gain_exponent(ident::Expression("x*v"), "v", gain, motion) == -1.0);
  CHECK(std::isnan(ident::gain_exponent(ident::Expression("0*x"), "a", gain, motion)));
}

}  // namespace test_sensors_absolute_gains
