#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "ident/state_space/records.hpp"
#include "ident/state_space/smoother.hpp"
#include "ident/state_space/start.hpp"

using namespace ident::state_space;

namespace test_noise_factors {

namespace {

/// Two records of one oscillator, the second with five times the noise of the first.
Problem unlike_records() {
  const support::Runs runs = support::runs_of(sim::Duffing{}, {0.8, 1.1}, 15.0, 100.0);
  Problem problem = support::problem_of(runs, {"x", "v", "x^3", "f"}, "x", 0.01, 71);
  const Problem noisier = support::problem_of(runs, {"x", "v", "x^3", "f"}, "x", 0.05, 72);
  problem.records[1] = noisier.records[1];
  return problem;
}

}  // namespace

TEST_CASE("a record with noise of its own is a channel of its own", "[ident][state_space]") {
  Problem problem = unlike_records();
  problem.channels[0].noise_std = 1e-3;
  problem.records[1].noise_factors = {5.0};
  Problem apart = unlike_records();
  apart.channels[0].noise_std = 1e-3;
  apart.channels.push_back(apart.channels[0]);
  apart.channels[1].noise_std = 5e-3;
  for (std::size_t r = 0; r < 2; ++r) {
    Eigen::MatrixXd& channels = apart.records[r].channels;
    const Eigen::VectorXd own = channels.col(0);
    channels.setConstant(own.size(), 2, std::numeric_limits<double>::quiet_NaN());
    channels.col(static_cast<Eigen::Index>(r)) = own;
  }
  const std::vector<int> sought{0, 1, 2, 3};
  const Linearisation one(problem), two(apart);
  const auto point_of = [](const Linearisation& of, const std::vector<std::vector<double>>& states) {
    const Layout& layout = of.model().layout();
    Point at{{-25.0, -1.0, -2500.0, 100.0}, states};
    at.parameters.resize(static_cast<std::size_t>(layout.size()), 0.0);
    for (int j = 0; j < layout.num_channels; ++j) at.parameters[static_cast<std::size_t>(layout.gain(j))] = 1.0;
    return at;
  };
  const std::vector<std::vector<double>> states = start_of(one).states;
  const auto first = one.about(point_of(one, states), sought, 1, 1),
             second = two.about(point_of(two, states), sought, 1, 1);
  REQUIRE((first && second));
  const Smoothed a = smooth(*first, {{1e-5, 1e-4}, {1e-3}}, false, 1),
                 b = smooth(*second, {{1e-5, 1e-4}, {1e-3, 5e-3}}, false, 1);
  const double samples = static_cast<double>(problem.records[1].channels.rows());
  CHECK(a.cost == Approx(b.cost).epsilon(1e-10));
  CHECK(a.J() + 2.0 * samples * std::log(5.0) == Approx(b.J()).epsilon(1e-9));  // the constant of the record's noise
  const std::vector<double> step = a.parameters.solve(), expected = b.parameters.solve(),
                            covariance = a.parameters.covariance(), expected_covariance = b.parameters.covariance();
  for (std::size_t i = 0; i < step.size(); ++i) CHECK(step[i] == Approx(expected[i]).epsilon(1e-7));
  for (std::size_t i = 0; i < covariance.size(); ++i)
    CHECK(covariance[i] == Approx(expected_covariance[i]).epsilon(1e-7).margin(1e-12));
}

TEST_CASE("noise that differs between recordings is told apart, and noise that does not is not",
          "[ident][state_space]") {
  Problem problem = unlike_records();
  tell_noise_apart(problem, {0, 1});
  CHECK(problem.records[1].noise_factor(0) / problem.records[0].noise_factor(0) == Approx(5.0).epsilon(0.1));
  Problem of_one = unlike_records();
  tell_noise_apart(of_one, {0, 0});  // pieces of one recording
  CHECK(of_one.records[0].noise_factor(0) == of_one.records[1].noise_factor(0));
  Problem alike = support::problem_of(support::runs_of(sim::Duffing{}, {0.8, 1.1}, 15.0, 100.0), {"x"}, "x", 0.01, 73);
  tell_noise_apart(alike, {0, 1});
  CHECK(alike.records[0].noise_factors.empty());
}

}  // namespace test_noise_factors
