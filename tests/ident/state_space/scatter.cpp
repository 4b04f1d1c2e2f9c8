#include "ident/state_space/scatter.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "ident/state_space/records.hpp"

using namespace ident::state_space;

namespace {

const std::vector<std::string> own_terms{"x", "v", "x^3", "f"};
const std::vector<double> own_values{-25, -1, -2500, 100};

/// Linear about the true motion of a Duffing oscillator, x with 1 % noise.
struct AtTruth {
  Linear linear;
  Noise noise;
};
AtTruth at_truth(const support::Runs& runs, std::uint64_t seed) {
  const Problem problem = support::problem_of(runs, own_terms, "x", 0.01, seed);
  const Linearisation linearisation(problem);
  Point point{own_values, {}};
  point.parameters.resize(static_cast<std::size_t>(linearisation.model().layout().size()));
  const std::vector<Prior> priors = priors_of(problem);
  for (std::size_t i = own_values.size(); i < point.parameters.size(); ++i) point.parameters[i] = priors[i].mean;
  double square = 0.0, samples = 0.0;
  for (std::size_t r = 0; r < runs.motions.size(); ++r) {
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> states =
        runs.motions[r].states.leftCols(2);
    point.states.emplace_back(states.data(), states.data() + states.size());
    square += (problem.records[r].channels.col(0) - states.col(0)).squaredNorm();
    samples += static_cast<double>(states.rows());
  }
  const auto linear = linearisation.about(point, {0, 1, 2, 3}, 2, 1);
  REQUIRE(linear);
  return {*linear, {{1e-5, 1e-4}, {std::sqrt(square / samples)}}};
}

}  // namespace

TEST_CASE("slopes of all stretches are the slope of the likelihood", "[ident][state_space]") {
  const support::Runs runs = support::runs_of(sim::Duffing{}, {0.9, 1.2}, 8.0, 50.0);
  const auto [linear, noise] = at_truth(runs, 3);
  const Triangle triangle = smooth(linear, noise, false, 1).parameters;
  const std::vector<double> slopes = slopes_of_stretches(linear, noise, 7);
  for (std::size_t i = 0; i < 4; ++i) {
    double sum = 0.0;
    for (std::size_t s = 0; s < 7; ++s) sum += slopes[4 * s + i];
    std::vector<double> above(4, 0.0), below(4, 0.0);
    const double width = 1e-3 * std::abs(own_values[i]);
    above[i] = width, below[i] = -width;
    // A quadratic: the central difference is exact but for rounding.
    CHECK(sum == Approx(-0.25 * (triangle.value(above) - triangle.value(below)) / width).epsilon(1e-6));
  }
}

TEST_CASE("where the equation is right the scatter of slopes is the curvature", "[ident][state_space]") {
  const support::Runs runs = support::runs_of(sim::Duffing{}, {0.8, 1.1}, 20.0, 50.0);
  constexpr int num_draws = 24;
  std::array<double, 4> ratio{};
  for (std::uint64_t draw = 0; draw < num_draws; ++draw) {
    const auto [linear, noise] = at_truth(runs, 940000 + draw);
    const std::vector<double> covariance = smooth(linear, noise, false, 1).parameters.covariance(),
                              scattered = scatter_covariance(linear, noise, covariance);
    for (std::size_t i = 0; i < 4; ++i) ratio[i] += scattered[5 * i] / covariance[5 * i] / num_draws;
  }
  // 31 degrees of freedom a draw: a standard deviation of sqrt(2 / 31 / 24) = 0.05, or of 0.08 for a parameter that few
  // stretches tell of; Student's factor is 1.08.
  for (const double one : ratio) CHECK(one == Approx(1.08).margin(0.25));
}

TEST_CASE("intervals cover under a white force that nobody recorded", "[.][coverage][state_space]") {
  constexpr int num_draws = 100;
  constexpr double rate_hz = 50.0, of_acceleration = 0.07;
  std::array<int, 4> own{}, wider{};
  int num_settled = 0;
  for (std::uint64_t draw = 0; draw < num_draws; ++draw) {
    sim::Duffing parameters;
    const sim::Noise white(941000 + draw, 99);
    support::Runs runs{.sample_rate_hz = rate_hz};
    for (const double ratio : {0.8, 1.1}) {
      parameters.ratio = ratio;
      sim::Experiment experiment = sim::make_experiment(parameters);
      const sim::SimulateOptions options{
          .duration_s = 30.0, .sample_rate_hz = rate_hz, .relative_tolerance = 1e-7, .max_step_s = 1.0 / rate_hz};
      const sim::Simulation quiet = sim::simulate(experiment.system, experiment.initial, options);
      const double size = of_acceleration *
                          std::sqrt(quiet.derivatives.col(1).squaredNorm() / static_cast<double>(quiet.time_s.size()));
      const std::uint64_t from = ratio > 1.0 ? 1'000'000 : 0;
      experiment.system.rhs = [=, rhs = experiment.system.rhs](double t, const double* y, int mode, double* dydt) {
        rhs(t, y, mode, dydt);
        dydt[1] += size * white.normal(from + static_cast<std::uint64_t>(t * rate_hz));
      };
      runs.motions.push_back(sim::simulate(experiment.system, experiment.initial, options));
      runs.forces.emplace_back(quiet.time_s.unaryExpr(experiment.system.forcing));
    }
    const Fit found = fit(support::problem_of(runs, own_terms, "x", 0.01, 942000 + draw), {});
    if (!found.settled || found.scattered.empty()) continue;
    ++num_settled;
    for (std::size_t i = 0; i < 4; ++i) {
      const double error = std::abs(found.point.parameters[i] - own_values[i]), std = found.std(i);
      own[i] += error <= 1.96 * std ? 1 : 0;
      const double scattered = std::sqrt(found.scattered[i * (found.parameters.size() + 1)]);
      wider[i] += error <= 1.96 * std::max(std, scattered) ? 1 : 0;
    }
  }
  CAPTURE(own, wider);
  CHECK(num_settled >= 95);
  // 0.95 +- 2 standard deviations of 100 draws is 0.906 to 0.994.
  for (const int covered : wider) CHECK(covered >= 0.90 * num_settled);
}
