#include <catch2/catch.hpp>

#include "ident/bodies/tally.hpp"
#include "ident/state_space/output_error.hpp"
#include "sim/chain.hpp"

// The force that an imposed motion takes.

namespace test_force_law {

namespace {

// A testing machine imposes x; what f is made of is computed by steps of fourth order, twenty a sample.
constexpr double rate_hz = 256.0, duration_s = 24.0;
constexpr std::uint64_t seed = 981000;

struct Damper {
  double stiffness = 2000.0, viscous = 50.0, cubic = 0.0;  ///< N/m, N s/m, N/m^3
  double take_up = 80e3, yield = 300.0;                    ///< N/m and N of z; 0: without a memory
  /// z' = k (v - (z^2 v + |v| z |z|) / (2 F^2)) [Wen76].
  [[nodiscard]] double rate(double z, double v) const {
    if (!(take_up > 0.0)) return 0.0;
    return take_up * (v - 0.5 * (z * z * v + std::abs(v) * z * std::abs(z)) / (yield * yield));
  }
};

/// Two sines whose sum comes and goes, as a machine is run.
double position(double t) {
  return 0.01 * std::sin(6.0 * t) + 0.006 * std::sin(9.3 * t + 1.0);
}
double speed(double t) {
  return 0.06 * std::cos(6.0 * t) + 0.0558 * std::cos(9.3 * t + 1.0);
}

dsp::Recording recording_of(const Damper& damper, double noise, std::uint64_t number, bool with_speed = false) {
  constexpr int parts = 20;
  constexpr double h = 1.0 / (rate_hz * parts);
  const auto n = static_cast<Eigen::Index>(rate_hz * duration_s);
  Eigen::VectorXd x(n), v(n), f(n);
  double z = 0.0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double t = static_cast<double>(k) / rate_hz;
    x(k) = position(t), v(k) = speed(t);
    f(k) = damper.stiffness * x(k) + damper.viscous * v(k) + damper.cubic * std::pow(x(k), 3) + z;
    for (int part = 0; part < parts; ++part) {
      const double at = t + part * h;
      const double a = damper.rate(z, speed(at)), b = damper.rate(z + 0.5 * h * a, speed(at + 0.5 * h)),
                   c = damper.rate(z + 0.5 * h * b, speed(at + 0.5 * h)), d = damper.rate(z + h * c, speed(at + h));
      z += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
  }
  dsp::Recording recording{.name = "damper", .sample_rate_hz = rate_hz};
  recording.samples.resize(n, with_speed ? 3 : 2);
  recording.samples.leftCols(2) << x, support::noisy(f, noise, number, 1000);
  recording.channels = {{.name = "x", .role = dsp::Role::x, .unit = "m"},
                        {.name = "f", .role = dsp::Role::f, .unit = "N"}};
  if (with_speed) {
    recording.samples.col(2) = v;
    recording.channels.push_back({.name = "v", .role = dsp::Role::v, .unit = "m/s"});
  }
  return recording;
}

ident::BodiesResult identified(const dsp::Recording& recording) {
  return ident::identify_bodies(ident::imposed_record(recording),
                                {.inner = ident::Inner::hysteresis, .num_threads = 2});
}

std::map<std::string, double> truth_of(const Damper& p) {
  std::map<std::string, double> truth{{"1 x", p.stiffness}, {"1 v", p.viscous}};
  if (p.cubic != 0.0) truth["1 x^3"] = p.cubic;
  if (!(p.take_up > 0.0)) return truth;
  const double bends = -0.5 * p.take_up / (p.yield * p.yield);
  truth["2 v"] = p.take_up, truth["2 z^2*v"] = bends, truth["2 z*abs(z)*abs(v)"] = bends;
  return truth;
}

}  // namespace

TEST_CASE("the force on an imposed motion is found with its memory", "[ident][force_law]") {
  const Damper damper;
  for (const bool with_speed : {false, true}) {
    const ident::BodiesResult result = identified(recording_of(damper, 0.01, seed, with_speed));
    support::BodiesTally of;
    of.add(result, truth_of(damper));
    CAPTURE(with_speed, result.sentence, result.silent_because);
    CHECK(of.exact == 1);
    CHECK(of.covered >= of.of - 1);
    CHECK(result.gain_of_inner > 100.0);
    CHECK(result.verdict == ident::Verdict::describes);
    REQUIRE(result.runs.size() == 1);
    CHECK(result.run_nmse(0) < 3e-4);  // of which noise of 1 % is 1e-4
    CHECK((result.loop.measured - result.loop.force).squaredNorm() < 3e-4 * result.loop.measured.squaredNorm());
  }
}

TEST_CASE("a force without a memory keeps none", "[ident][force_law]") {
  const Damper spring{.cubic = 5e6, .take_up = 0.0};
  const ident::BodiesResult result = identified(recording_of(spring, 0.02, seed + 1));
  support::BodiesTally of;
  of.add(result, truth_of(spring));
  CAPTURE(result.sentence);
  CHECK(of.exact == 1);
  CHECK(result.sought == ident::Inner::hysteresis);
  CHECK(result.model.layout.inner == ident::Inner::none);
  CHECK(result.verdict == ident::Verdict::describes);
  // Its one state is none of the force's, and has no first value to be sought.
  const ident::BodiesRecord record =
      ident::in_frame(ident::imposed_record(recording_of(spring, 0.02, seed + 1)), ident::Frame::ground);
  const auto state = ident::first_state(result.model, record, {500, 600}, 1);
  REQUIRE(state);
  CHECK(state->size() == 1);
}

TEST_CASE("terms that cannot be had on an imposed motion leave no equation", "[ident][force_law]") {
  const ident::BodiesResult result =
      ident::identify_bodies(ident::imposed_record(recording_of({}, 0.01, seed)),
                             {.library = {.terms = {"sqrt(x)"}}, .inner = ident::Inner::hysteresis});  // x < 0, too
  CHECK(!result.silent_because.empty());
  CHECK(result.sought == ident::Inner::hysteresis);
}

TEST_CASE("a stated delay is not ignored for an imposed motion", "[ident][force_law]") {
  dsp::Recording late = recording_of({}, 0.01, seed);
  late.channels[1].delay_s = 0.05;
  CHECK_THROWS_WITH(ident::imposed_record(late), Catch::Contains("`delay`"));
}

TEST_CASE("exact supports and coverage of the force on an imposed motion", "[.][coverage][force_law]") {
  const double noise = 0.01;  // at 5 % it hides the cubic term, which is 8 N of 400
  const Damper damper{.cubic = 2e6};
  support::BodiesTally of;
  for (std::uint64_t i = 0; i < 10; ++i)
    of.add(identified(recording_of(damper, noise, seed + 100 + i)), truth_of(damper));
  WARN(fmt::format("noise {}: exact {} of 10, {} of {} covered, worst error, median {:.2f} %", noise, of.exact,
                   of.covered, of.of, 100.0 * of.median_worst()));
  CHECK(of.exact >= 8);
  CHECK(static_cast<double>(of.covered) > 0.87 * of.of);
}

TEST_CASE("a force on an imposed motion is predicted from where it begins", "[ident][force_law]") {
  const Damper damper;
  const ident::BodiesResult result = identified(recording_of(damper, 0.0, seed));
  const ident::BodiesRecord record =
      ident::in_frame(ident::imposed_record(recording_of(damper, 0.0, seed)), ident::Frame::ground);
  // Not from rest: from amid the record, by samples of f over a fifth of a second.
  const dsp::IndexRange over{1000, 1050};
  const auto state = ident::first_state(result.model, record, over, 1);
  REQUIRE(state);
  const Eigen::MatrixXd inputs = record.input_samples.bottomRows(record.samples.rows() - 1000);
  const double begin_s = 1000.0 / rate_hz;
  const Eigen::MatrixXd states = ident::run_free(result.model, inputs, rate_hz, *state, 1.0, begin_s),
                        force = ident::responses_of(result.model, states, inputs, rate_hz, begin_s);
  CHECK(ident::errors_of_run(record, force, 1000, 1050).nmse(0) < 1e-6);
}

TEST_CASE("a motion that is missing, and recordings of one force", "[ident][force_law]") {
  dsp::Recording recording = recording_of({}, 0.01, seed);
  CHECK_THROWS_WITH(identified([&] {
                      dsp::Recording only_f = recording;
                      only_f.channels[0].role = dsp::Role::other;
                      return only_f;
                    }()),
                    Catch::Contains("no displacement"));
  // A mean of f is a force, not a zero.
  recording.samples.col(1).array() += 5e3;
  const ident::BodiesRecord both =
      ident::joined({ident::imposed_record(recording), ident::imposed_record(recording_of({}, 0.01, seed + 2))});
  CHECK(both.parts.size() == 2);
  CHECK(both.samples.col(0).head(100).mean() > 4e3);
}

TEST_CASE("slopes of equations that run on their own are those of differences", "[ident][force_law]") {
  using namespace ident::state_space;
  constexpr Eigen::Index n = 200;
  Problem problem{
      .equations = {.states = {"x", "v", "z"},
                    .inputs = {"u"},
                    .terms = {{"v", 0, 1.0}, {"x", 1}, {"v", 1}, {"z", 1, -1.0}, {"u", 1}, {"v", 2}, {"z*abs(v)", 2}}},
      .channels = {{.name = "x", .state = 0}, {.name = "a", .state = 1, .rate = true}},
      .records = {},
      .sample_rate_hz = 50.0};
  Record record{.channels = Eigen::MatrixXd::Zero(n, 2), .inputs = Eigen::MatrixXd(n, 1)};
  for (Eigen::Index k = 0; k < n; ++k) record.inputs(k, 0) = 20.0 * std::sin(0.13 * static_cast<double>(k));
  problem.records = {record, record};
  const std::vector<double> at{-90.0, -0.8, 1.1, 40.0, -3.0};
  // Settled at once: what is recorded is what is computed.
  const auto computed = [&](std::vector<double> coefficients) {
    Problem one = problem;
    for (std::size_t i = 0, k = 0; i < one.equations.terms.size(); ++i)
      if (!one.equations.terms[i].known) one.equations.terms[i].known = coefficients[k++];
    const auto run = output_error(one, {.free_states = {}});
    REQUIRE(run);
    return Eigen::VectorXd(-run->residual);
  };
  const Eigen::VectorXd middle = computed(at);
  for (std::size_t r = 0; r < 2; ++r)
    for (Eigen::Index k = 0; k < n; ++k)
      for (Eigen::Index j = 0; j < 2; ++j)
        problem.records[r].channels(k, j) = middle(static_cast<Eigen::Index>(r) * 2 * n + 2 * k + j);
  const auto run = output_error(problem, {.coefficients = at, .free_states = {0, 2}});
  REQUIRE(run);
  CHECK(run->squares() < 1e-20 * middle.squaredNorm());
  REQUIRE(run->slopes.cols() == 5 + 4);
  for (auto& one : problem.records) one.channels.setZero();
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double step = 1e-4 * std::abs(at[i]);
    std::vector<double> more = at, less = at;
    more[i] += step, less[i] -= step;
    const Eigen::VectorXd slope = (computed(more) - computed(less)) / (2.0 * step);
    CHECK((slope - run->slopes.col(static_cast<Eigen::Index>(i))).norm() < 1e-4 * slope.norm());
  }
  // First values of a record move its own outputs alone.
  CHECK(run->slopes.col(5).tail(2 * n).norm() == 0.0);
  CHECK(run->slopes.col(7).head(2 * n).norm() == 0.0);
  CHECK(run->slopes(0, 5) == 1.0);
}

}  // namespace test_force_law
