#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "ident/state_space/records.hpp"

using namespace ident::state_space;
using support::estimate_of;
using support::Runs;

namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// Within four standard deviations of the truth, and not by being uncertain: those are below `useful`.
void check_estimate(const Fit& fit, int parameter, double truth, double useful) {
  const auto [value, std] = estimate_of(fit, parameter);
  CAPTURE(parameter, value, std, truth);
  CHECK(std::abs(value - truth) < 4.0 * std);
  CHECK(std < useful);
}

void check_duffing(const Fit& fit, double share) {
  const double truth[4] = {-25.0, -1.0, -2500.0, 100.0};
  for (int i = 0; i < 4; ++i) check_estimate(fit, i, truth[i], share * std::abs(truth[i]));
}

const std::vector<std::string> duffing_terms{"x", "v", "x^3", "f"};

}  // namespace

TEST_CASE("any sample may be missing", "[ident][state_space]") {
  const Runs runs = support::runs_of(sim::Duffing{}, {0.8, 1.0, 1.2}, 25.0, 100.0);
  Problem problem = support::problem_of(runs, duffing_terms, "xa", 0.05, 930001);
  std::mt19937 engine(7);
  for (Record& record : problem.records) {
    for (Eigen::Index k = 0; k < record.channels.rows(); ++k)
      for (Eigen::Index j = 0; j < 2; ++j)
        if (engine() % 4 == 0) record.channels(k, j) = missing;
    record.channels.middleRows(600, 80).setConstant(missing);  // more than half a period of nothing
    record.channels.col(1).head(30).setConstant(missing);
  }
  const Fit fit = ident::state_space::fit(problem, {.num_threads = 1});
  CHECK(fit.converged());
  check_duffing(fit, 0.02);
}

TEST_CASE("a velocity alone, or an acceleration alone, gives the equation too", "[ident][state_space]") {
  const Runs runs = support::runs_of(sim::Duffing{}, {0.8, 1.0, 1.2}, 25.0, 100.0);
  const std::string channel = GENERATE("v", "a");
  CAPTURE(channel);
  const Fit fit =
      ident::state_space::fit(support::problem_of(runs, duffing_terms, channel, 0.05, 930002), {.num_threads = 1});
  CHECK(fit.converged());
  check_duffing(fit, 0.02);
}

TEST_CASE("without a recorded input the log-determinant finds the damping", "[ident][state_space]") {
  // x'' = -40 x - 0.5 x' + white force, held over a thousandth of a second each.
  constexpr double fine_s = 1e-3, k = 40.0, c = 0.5;
  Problem problem{.equations = oscillator({"x", "v"}), .channels = {{.name = "x"}}, .sample_rate_hz = 50.0};
  for (std::uint64_t r = 0; r < 2; ++r) {
    const sim::Noise force(930003, r), noise(930004, r);
    double x = 0.0, v = 0.0;
    Record record{Eigen::MatrixXd(2000, 1), Eigen::MatrixXd(2000, 0)};
    for (std::uint64_t i = 0; i < 20 * 3000; ++i) {
      v += fine_s * (-k * x - c * v) + std::sqrt(fine_s) * force.normal(i);  // symplectic: right to fine_s k / 2
      x += fine_s * v;
      if (i % 20 == 0 && i >= 20 * 1000)
        record.channels(static_cast<Eigen::Index>(i / 20) - 1000) = x + 0.008 * noise.normal(i);
    }
    problem.records.push_back(record);
  }
  const Fit fit = ident::state_space::fit(problem, {.num_threads = 1});
  CHECK(fit.settled);
  check_estimate(fit, 0, -k, 1.5);
  check_estimate(fit, 1, -c, 0.2);
  // Its spread over a step of h: a unit white force gives a velocity of variance h.
  CHECK(fit.noise.process[1] == Approx(std::sqrt(1.0 / 50.0)).epsilon(0.1));
}

TEST_CASE("what an equation lacks is process noise, and the score test names it", "[ident][state_space]") {
  const sim::Noise draw(930005, 0);
  Problem problem{.equations = oscillator({"1", "x", "v", "x^2", "x^3", "f", "abs(v)*v", "sgn(v)", "abs(x)*x"}, {"f"}),
                  .channels = {{.name = "x"}},
                  .sample_rate_hz = 100.0};
  for (const double omega : {3.7, 4.9, 6.1}) {
    const sim::System system{
        .name = "drag", .states = {"x", "v"}, .rhs = [=](double t, const double* y, int, double* dydt) {
          dydt[0] = y[1];
          dydt[1] = 100.0 * std::cos(omega * t) - y[1] - 25.0 * y[0] - 2500.0 * y[0] * y[0] * y[0] -
                    0.3 * std::abs(y[1]) * y[1];
        }};
    const sim::Simulation run =
        sim::simulate(system, Eigen::Vector2d::Zero(), {.duration_s = 25.0, .sample_rate_hz = 100.0});
    Record record{run.states.col(0), Eigen::MatrixXd(run.time_s.size(), 1)};
    for (Eigen::Index k = 0; k < run.time_s.size(); ++k) {
      record.inputs(k) = std::cos(omega * run.time_s(k));
      record.channels(k) +=
          0.005 * draw.normal(static_cast<std::uint64_t>(k) + static_cast<std::uint64_t>(1e4 * omega));
    }
    problem.records.push_back(record);
  }
  const std::vector<int> usual_forms{6, 7, 8};
  const Selection without = select(problem, {.fit = {.num_threads = 1}, .barred = usual_forms});
  CHECK(without.fit.gain_of_process_noise > 20.0);
  for (const int other : {0, 3, 7, 8})
    CHECK(without.scores[6].gain > without.scores[static_cast<std::size_t>(other)].gain);
  CHECK(without.scores[6].probability > 0.99);
  REQUIRE_FALSE(without.outside.empty());
  const Outside& best = without.outside.front();
  CHECK(best.term == 6);
  CHECK(best.explains > 0.8);
  const Selection with = select(problem, {.fit = {.num_threads = 1}, .barred = {7, 8}});
  for (const int term : {0, 6})
    CHECK(best.parameters[static_cast<std::size_t>(term)] ==
          Approx(with.fit.point.parameters[static_cast<std::size_t>(term)]).epsilon(0.01));
}

TEST_CASE("a fit that cannot reach the floor says so", "[ident][state_space]") {
  // A state that relaxes, and no speed whose process noise could take up the rest.
  Problem problem{.equations = {.states = {"x"}, .inputs = {"f"}, .terms = {{"x", 0}, {"f", 0}}},
                  .channels = {{.name = "x"}},
                  .records = {{Eigen::MatrixXd(1500, 1), Eigen::MatrixXd(1500, 1)}},
                  .sample_rate_hz = 100.0};
  const sim::Noise draw(930006, 0);
  constexpr double omega = 6.0, relaxes = 4.0, noise = 0.01;
  for (Eigen::Index k = 0; k < 1500; ++k) {
    const double t = 0.01 * static_cast<double>(k);
    problem.records[0].inputs(k) = std::cos(omega * t);
    problem.records[0].channels(k) =
        (relaxes * std::cos(omega * t) + omega * std::sin(omega * t)) / (relaxes * relaxes + omega * omega) +
        noise * draw.normal(static_cast<std::uint64_t>(k));
  }
  problem.channels[0].noise_std = noise;
  CHECK(ident::state_space::fit(problem, {.num_threads = 1}).converged());
  problem.channels[0].noise_std = 0.2 * noise;
  CHECK_FALSE(ident::state_space::fit(problem, {.num_threads = 1}).converged());
}

TEST_CASE("problems that do not fit together are refused", "[ident][state_space]") {
  const Runs runs = support::runs_of(sim::Duffing{}, {1.0}, 2.0, 100.0);
  const Problem good = support::problem_of(runs, duffing_terms, "x", 0.01, 1);
  const auto refused = [&](const auto& spoil) {
    Problem problem = good;
    spoil(problem);
    CHECK_THROWS_AS(fit(problem, {}), std::invalid_argument);
  };
  refused([](Problem& p) { p.sample_rate_hz = 0.0; });
  refused([](Problem& p) { p.channels[0].state = 2; });
  refused([](Problem& p) { p.equations.terms[1].state = -1; });
  refused([](Problem& p) { p.records[0].inputs(3) = missing; });
  refused([](Problem& p) { p.records[0].channels.setConstant(missing); });
  refused([](Problem& p) { p.records[0].channels.conservativeResize(5, 1); });
  CHECK_THROWS_AS(fit(good, {.terms = {4}}), std::invalid_argument);
  CHECK_THROWS_AS(fit(good, {.coefficients = {1.0}}), std::invalid_argument);
}

namespace {

/// x with errors of 2 % of its rms, each so much of the one before.
Problem wandering(const Runs& runs, double correlation, std::uint64_t seed) {
  Problem problem = support::problem_of(runs, duffing_terms, "x", 0.0, seed);
  for (std::size_t r = 0; r < problem.records.size(); ++r) {
    const sim::Noise draw(seed, r);
    auto x = problem.records[r].channels.col(0);
    const double std = 0.02 * std::sqrt(x.squaredNorm() / static_cast<double>(x.size()));
    const double fresh = std::sqrt(1.0 - correlation * correlation);
    double error = draw.normal(0);
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      x(k) += std * error;
      error = correlation * error + fresh * draw.normal(static_cast<std::uint64_t>(k) + 1);
    }
  }
  problem.channels.front().wanders = true;
  return problem;
}

}  // namespace

TEST_CASE("a zero that wanders is told from the motion", "[ident][state_space]") {
  const Runs runs = support::runs_of(sim::Duffing{}, {0.8, 1.0, 1.2}, 25.0, 100.0);
  Problem problem = wandering(runs, 0.99, 930090);
  // With terms that a shift of x mixes, too: where the zero begins is not free.
  problem.equations = oscillator({"x", "v", "x^3", "f", "1", "x^2"}, {"f"});
  const Fit shifted = ident::state_space::fit(problem, {.num_threads = 1});
  CHECK(shifted.converged());
  check_estimate(shifted, 2, -2500.0, 100.0);
  problem.equations = oscillator(duffing_terms, {"f"});
  const Fit fit = ident::state_space::fit(problem, {.num_threads = 1});
  CHECK(fit.converged());
  check_duffing(fit, 0.02);
  CHECK(fit.gain_of_process_noise < 20.0);
  problem.channels.front().wanders = false;
  CHECK(ident::state_space::fit(problem, {.num_threads = 1}).J > fit.J + 1000.0);
  problem.channels.front() = {.name = "a", .state = 1, .rate = true, .wanders = true};
  CHECK_THROWS_AS(ident::state_space::fit(problem, {.num_threads = 1}), std::invalid_argument);
}

TEST_CASE("intervals cover beside a sensor that wanders", "[.][coverage][state_space]") {
  const Runs runs = support::runs_of(sim::Duffing{}, {0.8, 1.0, 1.2}, 25.0, 100.0);
  const double correlation = GENERATE(0.9, 0.99), truth[4] = {-25.0, -1.0, -2500.0, 100.0};
  constexpr std::uint64_t first_seed = 930100, draws = 30;
  int covered = 0;
  for (std::uint64_t seed = first_seed; seed < first_seed + draws; ++seed) {
    const Fit fit = ident::state_space::fit(wandering(runs, correlation, seed), {.num_threads = 1});
    for (int i = 0; i < 4; ++i) {
      const auto [value, std] = estimate_of(fit, i);
      covered += fit.converged() && std::abs(value - truth[i]) <= 1.96 * std ? 1 : 0;
    }
  }
  WARN("correlation " << correlation << ": " << covered << " of " << 4 * draws << " covered");
  CHECK(covered >= (correlation < 0.95 ? 0.92 : 0.88) * 4 * draws);
}
