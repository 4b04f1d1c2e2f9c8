#include "ident/regression/collinearity.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using support::gaussian;

namespace {

// A motion of x within +-0.11 and an unrelated v, with a library on it.
struct Data {
  dsp::Motion motion;
  ident::CandidateLibrary library;
  MatrixXd phi;
};

Data data_of(const std::vector<std::string>& terms, double offset = 0.0, double amplitude = 0.11) {
  constexpr Index rows = 2000;
  Data data;
  data.motion.sample_rate_hz = 100.0;
  const VectorXd phase = VectorXd::LinSpaced(rows, 0.0, 40.0);
  data.motion.signals = {{"t", "s", phase},
                         {"x", "m", (amplitude * phase.array().sin() + offset).matrix()},
                         {"v", "m/s", gaussian(rows, 1, 3)},
                         {"a", "m/s^2", VectorXd::Zero(rows)}};
  data.library = ident::make_library({.order = 0, .terms = terms}, "a", data.motion);
  data.phi.resize(rows, static_cast<Index>(terms.size()));
  for (std::size_t j = 0; j < terms.size(); ++j)
    data.phi.col(static_cast<Index>(j)) = data.library.terms[j].expression.evaluate(data.motion);
  return data;
}

std::vector<std::string> remarks(const Data& data, const VectorXd& target) {
  const auto factor = ident::r_factor(data.phi, target);
  const double largest = data.motion.at("x").cwiseAbs().maxCoeff();
  std::vector<const ident::Term*> terms;
  for (const ident::Term& term : data.library.terms) terms.push_back(&term);
  return ident::collinearity_remarks(factor, ident::fit_fast_rvm(factor), terms, {{"x", largest}});
}

bool any(const std::vector<std::string>& remarks, const std::string& piece) {
  return std::any_of(remarks.begin(), remarks.end(),
                     [&](const std::string& remark) { return remark.find(piece) != std::string::npos; });
}

}  // namespace

TEST_CASE("variance inflation and condition number are those of the columns", "[ident][collinearity]") {
  MatrixXd phi = gaussian(500, 4, 1);
  phi.col(3) = 2.0 * phi.col(0) - phi.col(1) + 0.01 * phi.col(3);
  const auto found = ident::collinearity(ident::r_factor(phi, gaussian(500, 1, 2)));
  const MatrixXd unit = phi * phi.colwise().norm().cwiseInverse().asDiagonal();
  for (Index j = 0; j < 4; ++j) {
    // 1 / (1 - R^2) by least squares of one column on the others.
    std::vector<Index> others;
    for (Index k = 0; k < 4; ++k)
      if (k != j) others.push_back(k);
    const auto fit = ident::fit_ols(ident::r_factor(unit(Eigen::all, others), unit.col(j)));
    CHECK(found.inflation(j) == Approx(1.0 / (fit.noise_variance * (500 - 3))).epsilon(1e-8));
  }
  REQUIRE(found.dependences.size() == 1);
  const auto& near = found.dependences.front();
  CHECK(near.terms.size() == 3);
  VectorXd combined = VectorXd::Zero(500);
  for (std::size_t k = 0; k < near.terms.size(); ++k)
    combined += near.weights(static_cast<Index>(k)) * unit.col(near.terms[k]);
  CHECK(combined.norm() <= 2.0 * near.size);  // terms of small weight are left out
  CHECK(found.condition_number * near.size == Approx(unit.jacobiSvd().singularValues()(0)).epsilon(1e-8));
}

TEST_CASE("x and sin(x) are said to be indistinguishable where x is small", "[ident][collinearity]") {
  const Data data = data_of({"x", "sin(x)", "v"});
  const VectorXd target = -50.0 * data.phi.col(0) + 0.5 * data.phi.col(2) + 0.1 * gaussian(2000, 1, 4);
  const auto said = remarks(data, target);
  CHECK(any(said, "cannot be distinguished here: largest |x| 0.11"));
  CHECK(any(said, "x and sin(x)"));
}

TEST_CASE("x and sin(x) are distinguished where x is large, and nothing is said", "[ident][collinearity]") {
  const Data data = data_of({"x", "sin(x)", "v"}, 0.0, 2.0);
  CHECK(remarks(data, -50.0 * data.phi.col(0) + 0.1 * gaussian(2000, 1, 4)).empty());
}

TEST_CASE("equal columns, zero columns and constants beside the intercept are named", "[ident][collinearity]") {
  const Data data = data_of({"1", "x", "2*x", "0*v", "3+0*v", "v"});
  const auto said = remarks(data, 4.0 * data.phi.col(1) + 0.1 * gaussian(2000, 1, 5));
  CHECK((any(said, "2*x and x are proportional") || any(said, "x and 2*x are proportional")));
  CHECK(any(said, "was kept"));
  CHECK(any(said, "0*v is zero throughout"));
  CHECK((any(said, "1 and 3+0*v are proportional") || any(said, "3+0*v and 1 are proportional")));
}

TEST_CASE("of many kept terms that have a double only some are named and the rest counted", "[ident][collinearity]") {
  std::vector<std::string> terms;
  for (int power = 1; power <= 7; ++power) {
    terms.push_back("sin(" + std::to_string(power) + "*t)");
    terms.push_back("sin(" + std::to_string(power) + "*t+1e-4)");
  }
  const Data data = data_of(terms);
  VectorXd target = 0.1 * gaussian(2000, 1, 7);
  for (Index j = 0; j < 14; j += 2) target += data.phi.col(j);
  CHECK(any(remarks(data, target), "2 more kept terms cannot be distinguished from one left out"));
}

TEST_CASE("an offset of three hundred standard deviations is named and does not end in a lonely term",
          "[ident][collinearity]") {
  for (const double offset : {300.0, 1000.0, 3000.0}) {
    const Data data = data_of({"1", "x", "v", "x^2", "x*v", "v^2", "x^3"}, offset * 0.11 / std::sqrt(2.0));
    const VectorXd x = data.motion.at("x").array() - offset * 0.11 / std::sqrt(2.0);
    const VectorXd target = (-50.0 * x.array() - 0.8 * data.phi.col(2).array() - 900.0 * x.array().cube()).matrix() +
                            0.05 * gaussian(2000, 1, 6);
    const auto fit = ident::fit_fast_rvm(ident::r_factor(data.phi, target));
    INFO("offset " << offset);
    CHECK(fit.status == ident::FitStatus::converged);
    CHECK(fit.relevant.size() >= 4);
    CHECK(std::sqrt(fit.noise_variance) == Approx(0.05).epsilon(0.1));
    CHECK(!fit.remarks.empty());
    const auto said = remarks(data, target);
    CHECK(any(said, "x lies"));
    CHECK(any(said, "subtract its mean"));
  }
}
