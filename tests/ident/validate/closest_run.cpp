#include "ident/validate/closest_run.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "support/oscillator.hpp"

namespace test_validate_closest_run {

namespace {

const sim::Experiment& duffing() {
  static const sim::Experiment experiment = sim::make_experiment(sim::Duffing{.force_n = 0.5});
  return experiment;
}

/// The true equation with coefficients known to this fraction of themselves, each independent of the others.
ident::Model true_model(double relative_std, const std::string& without = {}) {
  ident::Model model{.target = "a"};
  for (const sim::TrueTerm& term : duffing().truth)
    if (term.row == 2 && term.name != without) model.terms.push_back({.name = term.name, .mean = term.value});
  Eigen::VectorXd std(std::ssize(model.terms));
  for (Eigen::Index i = 0; i < std.size(); ++i)
    std(i) = relative_std * std::abs(model.terms[static_cast<std::size_t>(i)].mean);
  model.covariance = std.cwiseAbs2().asDiagonal();
  return model;
}

ident::ModelTerm& term(ident::Model& model, const std::string& name) {
  return *std::find_if(model.terms.begin(), model.terms.end(), [&](const auto& one) { return one.name == name; });
}

/// The Duffing's motion, exact, from its second second on.
struct Record {
  dsp::Motion motion = support::motion_of(duffing(), 40.0, 50.0);
  ident::Course course{&motion,
                       {{50, motion.num_samples()}},
                       std::vector<unsigned char>(static_cast<std::size_t>(motion.num_samples()), 1)};
};

}  // namespace

TEST_CASE("coefficients within their intervals are found that follow x, beyond them they are not",
          "[ident][closest_run]") {
  const Record record;
  ident::Model off = true_model(0.05);
  term(off, "x").mean *= 1.09;
  term(off, "x^3").mean *= 0.9;
  const double as_it_is = ident::free_run(off, {record.course}).nmse_centred;
  REQUIRE(as_it_is > 5e-3);
  const auto closest = [&](const ident::Model& model) {
    return ident::closest_run(model, {record.course}, {}, 1e-5, {}).test.nmse_centred;
  };
  CHECK(closest(off) < 1e-4);
  off.covariance *= 1e-4;  // so that the truth is a hundred standard deviations away
  CHECK(closest(off) > 0.5 * as_it_is);
  off.covariance.resize(0, 0);
  CHECK(closest(off) == as_it_is);
}

TEST_CASE("no coefficients make up for a term that is missing", "[ident][closest_run]") {
  const Record record;
  const ident::Model lacking = true_model(0.05, "x^3");
  CHECK(ident::closest_run(lacking, {record.course}, {}, 1e-5, {}).test.nmse_centred > 0.1);
}

TEST_CASE("the same coefficients are to follow on test and on training rows", "[ident][closest_run]") {
  // The training rows are those of an oscillator with another stiffness.
  const Record record;
  Record other;
  other.motion = support::motion_of(
      sim::make_experiment(sim::Duffing{.omega_n = 1.07 * sim::Duffing{}.omega_n, .force_n = 0.5}), 40.0, 50.0);
  const ident::Model model = true_model(0.1);
  CHECK(ident::closest_run(model, {other.course}, {}, 1e-5, {}).test.nmse_centred < 1e-3);
  const ident::ClosestRun both = ident::closest_run(model, {record.course}, {other.course}, 1e-5, {});
  CHECK(std::max(both.test.nmse_centred, both.training.nmse_centred) > 1e-2);
}

}  // namespace test_validate_closest_run
