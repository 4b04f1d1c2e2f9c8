#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "ident/regression/r_factor.hpp"

// A regression t = Phi c + Psi eta + noise in which the values eta of sensor parameters have normal priors about zero.

namespace ident {

/// The R factor of [Psi Phi t], with what is known of eta beforehand.
struct SensorRegression {
  RFactor joint;                     ///< terms: n_s sensor columns, then b candidates
  Eigen::VectorXd prior_std;         ///< n_s
  std::vector<std::string> sources;  ///< n_s; parameters of one source share a line of the budget
  [[nodiscard]] Eigen::Index num_sensors() const { return prior_std.size(); }
};

/// Lets in further rows [Psi Phi t], which count as part of those that are there already.
void add_rows(SensorRegression& regression, const Eigen::Ref<const Eigen::MatrixXd>& rows);

/// The same regression on the candidates alone: what least squares and an evidence make of it is what they would make
/// of the joint one with eta integrated out, at this noise. Of b terms and as many samples.
[[nodiscard]] RFactor without_sensors(const SensorRegression& regression, double noise_std);
/// Standard deviation of the noise beside all candidates and sensors.
[[nodiscard]] double noise_beside_all(const SensorRegression& regression);

/// The most probable values of the sensors beside these candidates (0 .. b-1) with coefficients `mean`: n_s.
[[nodiscard]] Eigen::VectorXd sensor_mean(const SensorRegression& regression, const std::vector<Eigen::Index>& kept,
                                          const Eigen::Ref<const Eigen::VectorXd>& mean, double noise_std);

/// What a fit's coefficients and the sensors are known to, together.
struct SensorPosterior {
  Eigen::VectorXd sensor_mean, sensor_std;  ///< n_s
  Eigen::MatrixXd joint;                    ///< covariance of sensors and kept coefficients, for predictions
  Eigen::MatrixXd covariance;               ///< of the kept coefficients: noise and sensors
  Eigen::MatrixXd noise_covariance;         ///< with the sensors known
  std::vector<std::string> sources;         ///< "noise", then each source once
  double noise_std = 0.0;                   ///< it was computed with, of white noise
  Eigen::MatrixXd fractions;  ///< sources x kept: by what fraction the variance falls where that source is known;
                              ///< noise: the fraction that is left where all sensors are
};
/// What a fit makes of a sensor parameter.
struct SensorEstimate {
  std::string name, unit;
  double prior_std = 0.0, mean = 0.0, std = 0.0;
};
/// `kept`: candidates (0 .. b-1) with coefficients `mean`; variances beyond what a double holds are 0 or infinite;
/// `independent_fraction`: n_a / n, of the residual.
[[nodiscard]] SensorPosterior sensor_posterior(const SensorRegression& regression,
                                               const std::vector<Eigen::Index>& kept,
                                               const Eigen::Ref<const Eigen::VectorXd>& mean, double noise_std,
                                               double independent_fraction);
/// Sensors and candidates (0 .. b-1) whose columns are one and the same beyond these other candidates.
struct SensorTwin {
  Eigen::Index sensor = 0, candidate = 0;
};
[[nodiscard]] std::vector<SensorTwin> sensor_twins(const SensorRegression& regression,
                                                   const std::vector<Eigen::Index>& kept);
/// Lets in what terms too weak to be kept take from the kept ones, as the source "terms left out". `widening`: of each
/// standard deviation, at least 1.
void add_terms_left_out(SensorPosterior& posterior, const Eigen::Ref<const Eigen::VectorXd>& widening);

}  // namespace ident
