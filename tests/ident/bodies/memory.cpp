#include <catch2/catch.hpp>

#include "ident/bodies/tally.hpp"
#include "ident/state_space/start.hpp"
#include "sim/chain.hpp"
#include "sim/simulate.hpp"

// Forces with a memory, from the displacement alone.

namespace test_memory {

namespace {

constexpr double rate_hz = 100.0, duration_s = 100.0;
// Not the seeds that anything was tried on, which were 960100 to 960109.
constexpr std::uint64_t seed = 970000;

struct Draw {
  dsp::Recording recording;
  std::map<std::string, double> truth = {};
};

/// From rest under a random force, x with white noise of a fraction of its standard deviation.
template <class Parameters>
Draw draw_of(Parameters parameters, double noise, std::uint64_t number, double force_rms) {
  parameters.drive = sim::random_drive(number, 0.3, 2.0, force_rms).value;
  parameters.force_n = 1.0;
  const sim::Experiment experiment = sim::make_experiment(parameters);
  const sim::Simulation run =
      sim::simulate(experiment.system, experiment.initial, {.duration_s = duration_s, .sample_rate_hz = rate_hz});
  REQUIRE(run.status == sim::SimulationStatus::finished);
  const Eigen::VectorXd x = support::noisy(run.states.col(0), noise, number, 1000);
  Draw draw{{.name = "memory", .sample_rate_hz = rate_hz}};
  draw.recording.samples.resize(x.size(), 2);
  draw.recording.samples << x, run.time_s.unaryExpr(parameters.drive);
  draw.recording.channels = {{.name = "x", .role = dsp::Role::x, .unit = "m"},
                             {.name = "f", .role = dsp::Role::f, .unit = "N"}};
  for (const sim::TrueTerm& term : experiment.truth)
    if (term.row > 1 && term.name != "z") draw.truth[support::key(term.row - 1, term.name)] += term.value;
  return draw;
}

ident::BodiesResult identified(const dsp::Recording& recording, ident::Inner inner = ident::Inner::hysteresis,
                               std::vector<std::string> terms = {}) {
  return ident::identify_bodies(ident::bodies_record(recording, true),
                                {.library = {.terms = std::move(terms)}, .inner = inner, .num_threads = 2});
}

/// A pendulum of 1 Hz under a torque that an actuator passes on with a lag of first order, or whose sensor has one, 20
/// steps of fourth order a sample; at rest at first.
struct Pendulum {
  double square = 39.5, damping = 0.5, gain = 1.0, lag_s = 0.1, sensor_s = 0.0;
};
Draw draw_of(const Pendulum& p, double noise, std::uint64_t number, double torque_rms) {
  constexpr int parts = 20;
  constexpr double h = 1.0 / (rate_hz * parts);
  const auto torque = sim::random_drive(number, 0.2, 2.0, torque_rms).value;
  const auto rates = [&](double t, const Eigen::Vector4d& y) -> Eigen::Vector4d {
    const double late = p.lag_s > 0.0 ? y(2) : torque(t);
    return {y(1), -p.square * std::sin(y(0)) - p.damping * y(1) + p.gain * late,
            p.lag_s > 0.0 ? (torque(t) - y(2)) / p.lag_s : 0.0, p.sensor_s > 0.0 ? (y(0) - y(3)) / p.sensor_s : 0.0};
  };
  const auto n = static_cast<Eigen::Index>(rate_hz * duration_s) + 1;
  Eigen::VectorXd x(n), u(n);
  Eigen::Vector4d y = Eigen::Vector4d::Zero();
  for (Eigen::Index k = 0; k < n; ++k) {
    const double t = static_cast<double>(k) / rate_hz;
    x(k) = p.sensor_s > 0.0 ? y(3) : y(0), u(k) = torque(t);
    for (int part = 0; part < parts; ++part) {
      const double at = t + part * h;
      const Eigen::Vector4d a = rates(at, y), b = rates(at + 0.5 * h, y + 0.5 * h * a),
                            c = rates(at + 0.5 * h, y + 0.5 * h * b), d = rates(at + h, y + h * c);
      y += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
  }
  Draw draw{{.name = "pendulum", .sample_rate_hz = rate_hz}};
  draw.recording.samples.resize(n, 2);
  draw.recording.samples << support::noisy(x, noise, number, 1000), u;
  draw.recording.channels = {{.name = "x", .role = dsp::Role::x, .unit = "rad"},
                             {.name = "f", .role = dsp::Role::f, .unit = "N*m"}};
  draw.truth = {{"1 sin(x)", -p.square}, {"1 v", -p.damping}, {p.lag_s > 0.0 ? "1 z" : "1 f", p.gain}};
  if (p.lag_s > 0.0) draw.truth["2 (f - z)"] = 1.0 / p.lag_s;
  if (p.sensor_s > 0.0) draw.truth["2 (x - z)"] = 1.0 / p.sensor_s;
  return draw;
}

std::string in_words(const ident::BodiesResult& result) {
  std::string text = fmt::format("gain {:.4g} {}", result.gain_of_inner, result.silent_because);
  for (std::size_t j = 0; j < result.model.terms.size(); ++j)
    text +=
        fmt::format("  {} {:.4g}({:.2g})", support::key(result.model.terms[j].body, result.model.terms[j].name),
                    result.model.mean(static_cast<Eigen::Index>(j)), result.model.std(static_cast<Eigen::Index>(j)));
  return text;
}

/// An elastic part holds the motion where it began.
const sim::BoucWen bouc_wen{.a = 0.2};
/// As the model has it, in the scale of the whole force: z is (1 - a) of it.
std::map<std::string, double> in_scale_of_z(std::map<std::string, double> truth, const sim::BoucWen& p) {
  truth["2 v"] *= 1.0 - p.a;
  truth["2 z*abs(v)"] = -p.delta;
  return truth;
}

}  // namespace

TEST_CASE("a hidden hysteretic force is found from the displacement", "[ident][memory]") {
  const Draw draw = draw_of(bouc_wen, 0.01, seed, 40.0);
  const ident::BodiesResult result = identified(draw.recording);
  support::BodiesTally of;
  of.add(result, in_scale_of_z(draw.truth, bouc_wen));
  CAPTURE(result.sentence, result.silent_because);
  CHECK(of.exact == 1);
  CHECK(result.gain_of_inner > 50.0);
  CHECK(result.verdict == ident::Verdict::describes);
  // z is what the other terms leave of the acceleration: derived from x, that is uncertain by its noise alone.
  const ident::Loop& loop = result.loop;
  REQUIRE(loop.force.size() == loop.measured.size());
  CHECK((loop.measured - loop.force).squaredNorm() < 0.1 * loop.force.squaredNorm());
}

TEST_CASE("two recordings have one hysteretic force, each with a state of its own", "[ident][memory]") {
  const Draw first = draw_of(bouc_wen, 0.02, seed + 2, 40.0), second = draw_of(bouc_wen, 0.02, seed + 3, 25.0);
  const ident::BodiesResult result = ident::identify_bodies(
      ident::joined({ident::bodies_record(first.recording, true), ident::bodies_record(second.recording, true)}),
      {.inner = ident::Inner::hysteresis, .train_fraction = 0.3, .num_threads = 2});
  support::BodiesTally of;
  of.add(result, in_scale_of_z(first.truth, bouc_wen));
  CHECK(of.exact == 1);
  REQUIRE(result.runs.size() == 2);
  for (const ident::BodiesRun& run : result.runs) CHECK(run.errors.nmse.maxCoeff() < 0.01);
}

TEST_CASE("exact supports and errors of a hysteretic force", "[.][coverage][memory]") {
  const auto [noise, exact] = GENERATE(std::pair{0.01, 9}, std::pair{0.05, 8});
  support::BodiesTally of;
  for (std::uint64_t i = 0; i < 10; ++i) {
    const Draw draw = draw_of(bouc_wen, noise, seed + 100 + i, 40.0);
    const ident::BodiesResult result = identified(draw.recording);
    of.add(result, in_scale_of_z(draw.truth, bouc_wen));
    WARN(fmt::format("{} {} ", i, of.exact) + in_words(result));
  }
  const double share = static_cast<double>(of.covered) / of.of;
  WARN(fmt::format("noise {}: exact {} of 10, {} of {} covered ({:.3f}), worst error, median {:.2f} %", noise, of.exact,
                   of.covered, of.of, share, 100.0 * of.median_worst()));
  CHECK(of.exact >= exact);
  // Coefficients of one record err together: of ten records some twenty values are independent, 5 % their scatter.
  CHECK(share > 0.85);
}

TEST_CASE("of equations whose coefficients are all known z alone is an inner force", "[ident][memory]") {
  using ident::state_space::Equations;
  const Equations equations{.states = {"x", "v", "z"},
                            .terms = {{"v", 0, 1.0}, {"x", 1, -10.0}, {"v", 1, -0.3}, {"z", 1, -1.0}, {"v", 2, 40.0}}};
  const auto forces = ident::state_space::inner_forces(equations);
  REQUIRE(forces.size() == 1);
  CHECK(forces[0].state == 2);
  CHECK(forces[0].speed == 1);
  CHECK(forces[0].coefficient == -1.0);
}

TEST_CASE("a motion without memory keeps none", "[ident][memory]") {
  const Draw draw = draw_of(sim::Duffing{}, 0.02, seed + 1, 60.0);
  const ident::BodiesResult result = identified(draw.recording);
  support::BodiesTally of;
  of.add(result, draw.truth);
  CHECK(of.exact == 1);
  CHECK(result.sought == ident::Inner::hysteresis);
  CHECK(result.model.layout.inner == ident::Inner::none);
}

TEST_CASE("of forty motions without memory one at most keeps any", "[.][coverage][memory]") {
  int kept = 0, exact = 0;
  for (std::uint64_t i = 0; i < 40; ++i) {
    const double noise = i % 2 == 0 ? 0.01 : 0.05;
    const Draw draw =
        i % 4 < 2 ? draw_of(sim::Duffing{.epsilon = 25.0 * static_cast<double>(i % 5)}, noise, seed + 200 + i, 60.0)
                  : draw_of(sim::Coulomb{.k = 200.0, .c_f = 2.0}, noise, seed + 200 + i, 40.0);
    const ident::BodiesResult result = identified(draw.recording);
    support::BodiesTally of;
    of.add(result, draw.truth);
    exact += of.exact, kept += result.model.layout.inner == ident::Inner::none ? 0 : 1;
  }
  WARN(fmt::format("{} of 40 keep a memory, {} are exact", kept, exact));
  CHECK(kept <= 1);
}

TEST_CASE("an actuator's lag is found from the angle", "[ident][memory]") {
  const Pendulum p;
  const Draw draw = draw_of(p, 0.01, seed + 300, 8.0);
  const ident::BodiesResult result = identified(draw.recording, ident::Inner::lag, {"sin(x)"});
  support::BodiesTally of;
  of.add(result, draw.truth);
  CAPTURE(result.sentence, result.silent_because);
  CHECK(of.exact == 1);
  CHECK(result.gain_of_inner > 50.0);
  CHECK(result.verdict == ident::Verdict::describes);
  CHECK(std::abs(result.lag_s - p.lag_s) < 3.0 * result.lag_std_s);
  CHECK(result.lag_std_s < 0.02 * p.lag_s);
}

TEST_CASE("a displacement sensor's lag is found, and told from an actuator's", "[ident][memory]") {
  const Pendulum p{.lag_s = 0.0, .sensor_s = 0.05};
  const Draw draw = draw_of(p, 0.01, seed + 310, 12.0);
  const ident::BodiesResult result = identified(draw.recording, ident::Inner::lag, {"sin(x)"});
  support::BodiesTally of;
  of.add(result, draw.truth);
  INFO(in_words(result));
  CHECK(of.exact == 1);
  CHECK(result.model.layout.sensor_lags());
  CHECK(result.verdict == ident::Verdict::describes);
  CHECK(std::abs(result.lag_s - p.sensor_s) < 3.0 * result.lag_std_s);
  CHECK(result.lag_std_s < 0.02 * p.sensor_s);
}

TEST_CASE("a motion whose force arrives at once has no lag", "[ident][memory]") {
  const Draw draw = draw_of(Pendulum{.lag_s = 0.0}, 0.01, seed + 301, 8.0);
  const ident::BodiesResult result = identified(draw.recording, ident::Inner::lag, {"sin(x)"});
  support::BodiesTally of;
  of.add(result, draw.truth);
  CHECK(of.exact == 1);
  CHECK(result.sought == ident::Inner::lag);
  CHECK(result.model.layout.inner == ident::Inner::none);
}

TEST_CASE("a lag cannot be sought where nothing acts from outside", "[ident][memory]") {
  Draw draw = draw_of(Pendulum{}, 0.01, seed + 302, 8.0);
  draw.recording.channels.pop_back();
  draw.recording.samples.conservativeResize(Eigen::NoChange, 1);
  CHECK_THROWS_WITH(identified(draw.recording, ident::Inner::lag), Catch::Contains("of a recorded force"));
}

TEST_CASE("exact supports and errors of a lag", "[.][coverage][memory]") {
  struct Level {
    double actuator_s, sensor_s, torque;
  };
  // A slow actuator passes on less: at small angles and 5 % noise sin(x) is x - x^3 / 6.
  for (const Level& level :
       {Level{0.03, 0.0, 8.0}, {0.1, 0.0, 8.0}, {0.3, 0.0, 12.0}, {0.0, 0.03, 12.0}, {0.0, 0.1, 12.0}})
    for (const double noise : {0.01, 0.05})
      DYNAMIC_SECTION("actuator " << level.actuator_s << " s, sensor " << level.sensor_s << " s, noise " << noise) {
        support::BodiesTally of;
        int covered = 0;
        for (std::uint64_t i = 0; i < 10; ++i) {
          const Draw draw = draw_of(Pendulum{.lag_s = level.actuator_s, .sensor_s = level.sensor_s}, noise,
                                    seed + 400 + i, level.torque);
          const ident::BodiesResult result = identified(draw.recording, ident::Inner::lag, {"sin(x)"});
          of.add(result, draw.truth);
          const double error = std::abs(result.lag_s - level.actuator_s - level.sensor_s);
          covered += error < 1.96 * result.lag_std_s ? 1 : 0;
          WARN(fmt::format("{} {} ", i, of.exact) + in_words(result));
        }
        WARN(fmt::format("exact {} of 10, lag covered {}, {} of {} coefficients covered, worst error, median {:.2f} %",
                         of.exact, covered, of.covered, of.of, 100.0 * of.median_worst()));
        CHECK(of.exact >= 9);
        CHECK(covered >= 9);
      }
}

}  // namespace test_memory
