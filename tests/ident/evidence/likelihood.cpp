#include "ident/evidence/likelihood.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "ident/identify.hpp"
#include "ident/state_space/start.hpp"
#include "sim/noise.hpp"
#include "sim/simulate.hpp"
#include "sim/systems.hpp"

namespace {

using Eigen::Index;
using Law = std::vector<std::pair<std::string, double>>;

/// What is recorded of an oscillator under two tones, or released at 0.3 m where it has no force.
struct Setup {
  double duration_s = 60.0, rate_hz = 100.0, noise = 0.02;  ///< of each channel's standard deviation
  bool accelerometer = false, force = true;
  double gain = 1.0;  ///< of the accelerometer
  std::uint64_t seed = 930000;
};

const Law duffing_law{{"x", -25.0}, {"v", -1.0}, {"x^3", -2500.0}, {"f", 100.0}};

sim::System duffing(double quadratic, bool driven) {
  const auto force = [=](double t) { return driven ? std::sin(4.1 * t) + 0.7 * std::sin(6.3 * t + 1.0) : 0.0; };
  sim::System system;
  system.forcing = force;
  system.states = {"x", "v"};
  system.rhs = [=](double t, const double* s, int, double* rates) {
    rates[0] = s[1];
    rates[1] = -25.0 * s[0] - s[1] - 2500.0 * s[0] * s[0] * s[0] - quadratic * std::abs(s[1]) * s[1] + 100.0 * force(t);
  };
  return system;
}

dsp::Recording recording_of(const Setup& setup, double quadratic = 0.0) {
  const sim::System system = duffing(quadratic, setup.force);
  const sim::Simulation motion = sim::simulate(system, Eigen::Vector2d(setup.force ? 0.0 : 0.3, 0.0),
                                               {.duration_s = setup.duration_s, .sample_rate_hz = setup.rate_hz});
  dsp::Recording recording{.name = "bench", .sample_rate_hz = setup.rate_hz};
  const auto add = [&](const std::string& name, dsp::Role role, const std::string& unit, Eigen::VectorXd values) {
    const sim::Noise draw(setup.seed, static_cast<std::uint64_t>(recording.channels.size()));
    const double std = setup.noise * std::sqrt((values.array() - values.mean()).square().mean());
    for (Index i = 0; i < values.size(); ++i) values(i) += std * draw.normal(static_cast<std::uint64_t>(i));
    recording.channels.push_back({.name = name, .role = role, .unit = unit});
    recording.samples.conservativeResize(values.size(), std::ssize(recording.channels));
    recording.samples.rightCols(1) = values;
  };
  add("laser", dsp::Role::x, "m", motion.states.col(0));
  if (setup.accelerometer) add("icp", dsp::Role::a, "m/s^2", setup.gain * motion.derivatives.col(1));
  if (setup.force) add("cell", dsp::Role::f, "N", motion.time_s.unaryExpr(system.forcing));
  return recording;
}

ident::RangeResult found_in(const dsp::Recording& recording, std::vector<std::string> terms = {"f", "abs(v)*v"}) {
  ident::Record record{.prepared = dsp::prepare(recording, {})};
  return ident::identify(std::move(record), {.order = 3, .terms = std::move(terms)},
                         {.methods = {ident::FastRvmOptions{}}})
      .front();
}

std::vector<std::string> kept_terms(const ident::JudgedFit& fit) {
  std::vector<std::string> names;
  for (const ident::ModelTerm& term : fit.model.terms) names.push_back(term.name);
  return names;
}

/// Largest error of a coefficient in its standard deviations.
double largest_deviation(const ident::JudgedFit& fit) {
  double largest = 0.0;
  for (const ident::ModelTerm& term : fit.model.terms)
    for (const auto& [name, value] : duffing_law)
      if (name == term.name) largest = std::max(largest, std::abs(term.mean - value) / term.std);
  return largest;
}

const std::vector<std::string> duffing_terms{"x", "v", "x^3", "f"};
// Of four coefficients at a time, of ten records: a normal deviate beyond it once in 16,000.
constexpr double far = 4.0;

}  // namespace

TEST_CASE("samples as recorded give the equation of a displacement under noise", "[ident][likelihood]") {
  for (std::uint64_t seed = 930000; seed < 930005; ++seed) {
    const ident::RangeResult range = found_in(recording_of({.noise = 0.05, .seed = seed}));
    CAPTURE(seed, range.likelihood.silent_because);
    const ident::JudgedFit& fit = range.fits.front();
    CHECK(fit.by_likelihood);
    CHECK(kept_terms(fit) == duffing_terms);
    CHECK(largest_deviation(fit) < far);
    CHECK_FALSE(range.likelihood.has_unexplained());
    CHECK_FALSE(range.likelihood.missing);
  }
}

TEST_CASE("noise of a recorded force neither lowers its coefficient nor narrows an interval", "[ident][likelihood]") {
  // A tenth of the force's rms is noise; least squares on it as it is would find 1 % less.
  const ident::RangeResult range = found_in(recording_of({.noise = 0.1}));
  const ident::JudgedFit& fit = range.fits.front();
  REQUIRE(fit.by_likelihood);
  CHECK(kept_terms(fit) == duffing_terms);
  CHECK(largest_deviation(fit) < far);
  CHECK_FALSE(range.likelihood.has_unexplained());
}

TEST_CASE("an accelerometer's gain is found beside the equation", "[ident][likelihood]") {
  const double gain = 1.015;
  const ident::RangeResult range = found_in(recording_of({.accelerometer = true, .gain = gain}));
  const ident::JudgedFit& fit = range.fits.front();
  REQUIRE(fit.by_likelihood);
  CHECK(kept_terms(fit) == duffing_terms);
  CHECK(largest_deviation(fit) < far);
  const auto found = std::find_if(fit.sensors.begin(), fit.sensors.end(),
                                  [](const ident::SensorEstimate& one) { return one.name == "gain of icp"; });
  REQUIRE(found != fit.sensors.end());
  CHECK(std::abs(found->mean - (gain - 1.0)) < far * found->std);
  CHECK(found->std < 0.1 * found->prior_std);
}

TEST_CASE("a law that is no candidate is named, and does not pass for noise", "[ident][likelihood]") {
  const ident::RangeResult range = found_in(recording_of({.noise = 0.005}, 0.3), {"f"});
  REQUIRE(range.likelihood.speaks());
  REQUIRE(range.likelihood.missing);
  CHECK(range.likelihood.missing->what == "abs(v)*v");
  CHECK(range.fits.front().judgement.verdict != ident::Verdict::describes);
}

TEST_CASE("a force that was recorded and is no candidate is named", "[ident][likelihood]") {
  const ident::RangeResult range = found_in(recording_of({}), {});
  const ident::Judgement& judgement = range.fits.front().judgement;
  REQUIRE(judgement.named);
  CHECK(judgement.named->what == "f");
  CHECK(judgement.verdict == ident::Verdict::does_not);
}

TEST_CASE("faulty samples are missing ones, and cost nothing beside them", "[ident][likelihood]") {
  dsp::Recording recording = recording_of({.duration_s = 40.0, .force = false});
  const auto from = recording.samples.rows() / 4;
  recording.samples.middleRows(from, 30).setConstant(0.3);  // a spike of 0.3 s, known as such
  recording.bad.push_back({static_cast<double>(from) / 100.0, static_cast<double>(from + 30) / 100.0, "annotated"});
  const ident::RangeResult range = found_in(recording, {});
  CAPTURE(range.likelihood.silent_because);
  REQUIRE(range.likelihood.num_samples > 0.0);
  // From the first sample to the last row of training, whatever filters spoil at the ends or beside the spike.
  const double last_s = range.rows.train_s.back().to_s;
  CHECK(range.likelihood.num_samples == Approx(100.0 * last_s - 30.0).margin(3.0));
}

TEST_CASE("what the likelihood is not made for is left to the regression, which says why", "[ident][likelihood]") {
  dsp::Recording recording = recording_of({.duration_s = 20.0});
  SECTION("a difference of two displacements") {
    recording.channels[0].role = dsp::Role::y;
    recording.channels.push_back({.name = "base", .role = dsp::Role::r, .unit = "m"});
    recording.samples.conservativeResize(Eigen::NoChange, 3);
    recording.samples.col(2) = 0.1 * recording.samples.col(1);
    const ident::RangeResult range = found_in(recording);
    CHECK(range.likelihood.silent_because.find("difference") != std::string::npos);
    CHECK_FALSE(range.fits.front().by_likelihood);
  }
  SECTION("a method that was asked for with a threshold of its own") {
    ident::Record record{.prepared = dsp::prepare(recording, {})};
    const auto ranges = ident::identify(std::move(record), {.order = 3, .terms = {"f"}},
                                        {.methods = {ident::FastRvmOptions{.tau = 30.0}}});
    CHECK_FALSE(ranges.front().fits.front().by_likelihood);
  }
}

TEST_CASE("noise is taken off an input where it is noise", "[ident][state_space]") {
  constexpr double rate_hz = 100.0, std = 0.1;
  Eigen::VectorXd clean(4000), noisy(4000);
  const sim::Noise draw(930100, 0);
  for (Index i = 0; i < clean.size(); ++i) {
    clean(i) = std::sin(4.1 * static_cast<double>(i) / rate_hz);
    noisy(i) = clean(i) + std * draw.normal(static_cast<std::uint64_t>(i));
  }
  const ident::state_space::Input input = ident::state_space::without_noise(noisy, rate_hz);
  CHECK(input.noise_std == Approx(std).epsilon(0.1));  // a median of 800 ordinates
  const auto inner = [](const Eigen::VectorXd& values) { return values.segment(100, 3800); };
  CHECK(inner(input.signal - clean).norm() < 0.3 * inner(noisy - clean).norm());
  // What is as strong at every frequency is an input of its own.
  const Eigen::VectorXd random = noisy - clean;
  const ident::state_space::Input kept = ident::state_space::without_noise(random, rate_hz);
  CHECK(kept.signal == random);
  CHECK(kept.noise_std == 0.0);
}
