#include "ident/sensors/sensor_fit.hpp"

#include <Eigen/QR>
#include <catch2/catch.hpp>
#include <cmath>

#include "ident/regression/fit.hpp"
#include "support/random.hpp"

namespace test_sensors_sensor_fit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using support::gaussian;

namespace {

constexpr Index num_rows = 300;
constexpr double noise_std = 0.2;
const VectorXd prior_std{{0.3, 0.05}};
const VectorXd truth{{1.0, -2.0, 0.5}};

/// Sensor columns that lean on the candidates, as those of gains do.
struct Simulation {
  MatrixXd phi, psi;
  VectorXd target;
  ident::SensorRegression regression;
};

Simulation simulated(unsigned seed) {
  Simulation s;
  s.phi = gaussian(num_rows, 3, 10 * seed);
  s.psi = gaussian(num_rows, 2, 10 * seed + 1);
  s.psi.col(0) += 2.0 * s.phi.col(0) - s.phi.col(1);
  s.psi.col(1) += s.phi.col(2);
  const VectorXd eta = prior_std.cwiseProduct(VectorXd(gaussian(2, 1, 10 * seed + 2)));
  s.target = s.phi * truth + s.psi * eta + noise_std * gaussian(num_rows, 1, 10 * seed + 3);
  MatrixXd both(num_rows, 5);
  both << s.psi, s.phi;
  s.regression = {ident::r_factor(both, s.target), prior_std, {"gain", "drift"}};
  return s;
}

}  // namespace

TEST_CASE("least squares with the sensors integrated out are those with their priors as rows", "[ident][sensor_fit]") {
  const Simulation s = simulated(1);
  MatrixXd rows = MatrixXd::Zero(num_rows + 2, 5);
  rows.topRows(num_rows) << s.psi, s.phi;
  rows.bottomLeftCorner(2, 2).diagonal() = noise_std * prior_std.cwiseInverse();
  VectorXd target = VectorXd::Zero(num_rows + 2);
  target.head(num_rows) = s.target;
  const VectorXd joint = rows.householderQr().solve(target);
  const auto fit = ident::fit_ols(ident::without_sensors(s.regression, noise_std));
  CHECK((fit.mean - joint.tail(3)).cwiseAbs().maxCoeff() < 1e-12);
  const auto posterior = ident::sensor_posterior(s.regression, {0, 1, 2}, fit.mean, noise_std, 1.0);
  CHECK((posterior.sensor_mean - joint.head(2)).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(ident::noise_beside_all(s.regression) == Approx(noise_std).epsilon(0.15));  // 300 rows: 4 %
}

TEST_CASE(
    "95 % intervals hold the truth of coefficients that sensors disturb in 95 of 100 cases, those of the noise do "
    "not",
    "[ident][sensor_fit]") {
  constexpr unsigned num_seeds = 600;
  int held = 0, held_by_noise = 0, sensors_held = 0;
  for (unsigned seed = 1; seed <= num_seeds; ++seed) {
    const Simulation s = simulated(seed);
    const auto fit = ident::fit_ols(ident::without_sensors(s.regression, ident::noise_beside_all(s.regression)));
    const auto posterior =
        ident::sensor_posterior(s.regression, {0, 1, 2}, fit.mean, std::sqrt(fit.noise_variance), 1.0);
    const VectorXd eta = prior_std.cwiseProduct(VectorXd(gaussian(2, 1, 10 * seed + 2)));
    for (Index j = 0; j < 3; ++j) {
      held += std::abs(fit.mean(j) - truth(j)) < 1.96 * std::sqrt(posterior.covariance(j, j));
      held_by_noise += std::abs(fit.mean(j) - truth(j)) < 1.96 * std::sqrt(posterior.noise_covariance(j, j));
    }
    for (Index i = 0; i < 2; ++i)
      sensors_held += std::abs(posterior.sensor_mean(i) - eta(i)) < 1.96 * posterior.sensor_std(i);
  }
  // Of 1800 (1200): 0.95 +- 0.005 (0.006).
  CHECK(held / (3.0 * num_seeds) == Approx(0.95).margin(0.02));
  CHECK(sensors_held / (2.0 * num_seeds) == Approx(0.95).margin(0.025));
  CHECK(held_by_noise / (3.0 * num_seeds) < 0.9);
}

TEST_CASE("the budget names what a coefficient's variance would fall by", "[ident][sensor_fit]") {
  Simulation s = simulated(2);
  const VectorXd mean = ident::fit_ols(ident::without_sensors(s.regression, noise_std)).mean;
  const double variance = noise_std * noise_std;
  const auto posterior = ident::sensor_posterior(s.regression, {0, 1, 2}, mean, std::sqrt(variance), 1.0);
  REQUIRE(posterior.sources == std::vector<std::string>{"noise", "gain", "drift"});
  s.regression.prior_std(0) = 1e-9;  // calibrated
  const auto known = ident::sensor_posterior(s.regression, {0, 1, 2}, mean, std::sqrt(variance), 1.0);
  for (Index j = 0; j < 3; ++j) {
    CHECK(posterior.fractions(1, j) == Approx(1.0 - known.covariance(j, j) / posterior.covariance(j, j)).margin(1e-9));
    CHECK(posterior.fractions(0, j) == Approx(posterior.noise_covariance(j, j) / posterior.covariance(j, j)));
  }
  CHECK(posterior.fractions(1, 0) > posterior.fractions(2, 0));  // the gain disturbs the first candidate
}

TEST_CASE("rows that are worth half widen the noise's part and leave the priors alone", "[ident][sensor_fit]") {
  const Simulation s = simulated(3);
  const VectorXd mean = ident::fit_ols(ident::without_sensors(s.regression, noise_std)).mean;
  const auto half = ident::sensor_posterior(s.regression, {0, 1, 2}, mean, noise_std, 0.5);
  const auto louder = ident::sensor_posterior(s.regression, {0, 1, 2}, mean, std::sqrt(2.0) * noise_std, 1.0);
  CHECK((half.covariance - louder.covariance).cwiseAbs().maxCoeff() < 1e-12);
}

}  // namespace test_sensors_sensor_fit
