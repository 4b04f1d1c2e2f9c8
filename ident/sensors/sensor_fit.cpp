#include "ident/sensors/sensor_fit.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// R of the stacked rows, upper triangular, as wide as they are.
MatrixXd triangle(const MatrixXd& rows) {
  MatrixXd R = MatrixXd::Zero(rows.cols(), rows.cols());
  const Eigen::HouseholderQR<MatrixXd> qr(rows);
  const Index height = std::min(rows.rows(), rows.cols());
  R.topRows(height) = qr.matrixQR().topRows(height).triangularView<Eigen::Upper>();
  return R;
}

/// Covariance of the unknowns of least squares on these rows of unit variance: (A'A)^-1, columns at unit norm inside.
MatrixXd covariance_of(const MatrixXd& rows) {
  const VectorXd scale = rows.colwise().norm().transpose().cwiseMax(std::numeric_limits<double>::min());
  const MatrixXd R = triangle(rows * scale.cwiseInverse().asDiagonal());
  const MatrixXd root = R.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(R.cols(), R.cols()));
  const MatrixXd scaled = scale.cwiseInverse().asDiagonal() * root;
  return scaled * scaled.transpose();
}

/// The joint rows over the noise, above those of the priors, for these sensor columns and candidates.
MatrixXd rows_of(const SensorRegression& regression, const std::vector<Index>& sensors, const std::vector<Index>& kept,
                 double noise_std) {
  const auto n_s = static_cast<Index>(sensors.size()), k = static_cast<Index>(kept.size());
  const MatrixXd& R = regression.joint.R;
  MatrixXd rows = MatrixXd::Zero(R.rows() + n_s, n_s + k);
  for (Index i = 0; i < n_s; ++i) {
    const Index sensor = sensors[static_cast<std::size_t>(i)];
    rows.col(i).head(R.rows()) = R.col(sensor) / noise_std;
    rows(R.rows() + i, i) = 1.0 / regression.prior_std(sensor);
  }
  for (Index j = 0; j < k; ++j)
    rows.col(n_s + j).head(R.rows()) = R.col(regression.num_sensors() + kept[static_cast<std::size_t>(j)]) / noise_std;
  return rows;
}

std::vector<Index> sensors_but(const SensorRegression& regression, const std::string& source) {
  std::vector<Index> left;
  for (Index i = 0; i < regression.num_sensors(); ++i)
    if (regression.sources[static_cast<std::size_t>(i)] != source) left.push_back(i);
  return left;
}

}  // namespace

RFactor without_sensors(const SensorRegression& regression, double noise_std) {
  const Index n_s = regression.num_sensors(), width = regression.joint.R.cols() - n_s;
  MatrixXd rows = MatrixXd::Zero(regression.joint.R.rows() + n_s, regression.joint.R.cols());
  rows.topRows(regression.joint.R.rows()) = regression.joint.R;
  rows.bottomLeftCorner(n_s, n_s).diagonal() = noise_std * regression.prior_std.cwiseInverse();
  const MatrixXd R = triangle(rows);
  return {R.bottomRightCorner(width, width), width - 1, regression.joint.num_samples};
}

double noise_beside_all(const SensorRegression& regression) {
  const Index b = regression.joint.num_terms - regression.num_sensors();
  const double rows_to_spare = std::max(1.0, static_cast<double>(regression.joint.num_samples - b));
  // From above, as without sensors: unheld by their priors, the gains of two accelerometers make up any target.
  double noise_std = std::abs(triangle(regression.joint.R.rightCols(b + 1))(b, b)) / std::sqrt(rows_to_spare);
  constexpr int most_passes = 20;
  constexpr double close = 1e-3;  // of the noise: a hundredth of what 10^4 rows tell
  for (int pass = 0; pass < most_passes; ++pass) {
    const RFactor left = without_sensors(regression, noise_std);
    const double before = std::exchange(noise_std, std::abs(left.R(b, b)) / std::sqrt(rows_to_spare));
    if (noise_std >= (1.0 - close) * before) break;
  }
  return noise_std;
}

SensorPosterior sensor_posterior(const SensorRegression& regression, const std::vector<Index>& kept,
                                 const Eigen::Ref<const VectorXd>& mean, double noise_variance,
                                 double independent_fraction) {
  const Index n_s = regression.num_sensors(), k = static_cast<Index>(kept.size());
  const std::vector<Index> all = sensors_but(regression, "");
  const double white = std::sqrt(noise_variance), noise_std = white / std::sqrt(independent_fraction);
  SensorPosterior result;
  const MatrixXd joint = covariance_of(rows_of(regression, all, kept, noise_std));
  result.covariance = joint.bottomRightCorner(k, k);
  result.noise_covariance = covariance_of(rows_of(regression, {}, kept, white));
  result.sensor_std = joint.diagonal().head(n_s).cwiseSqrt();
  const MatrixXd& R = regression.joint.R;
  VectorXd left = VectorXd::Zero(R.rows() + n_s);
  left.head(R.rows()) = R.col(R.cols() - 1);
  for (Index j = 0; j < k; ++j) left.head(R.rows()) -= mean(j) * R.col(n_s + kept[static_cast<std::size_t>(j)]);
  result.sensor_mean = rows_of(regression, all, {}, noise_std).householderQr().solve(left / noise_std);

  result.sources = {"noise"};
  for (const std::string& source : regression.sources)
    if (std::find(result.sources.begin(), result.sources.end(), source) == result.sources.end())
      result.sources.push_back(source);
  result.fractions.resize(static_cast<Index>(result.sources.size()), k);
  const VectorXd total = result.covariance.diagonal();
  result.fractions.row(0) =
      covariance_of(rows_of(regression, {}, kept, noise_std)).diagonal().cwiseQuotient(total).transpose();
  for (std::size_t i = 1; i < result.sources.size(); ++i) {
    const std::vector<Index> others = sensors_but(regression, result.sources[i]);
    const MatrixXd known = covariance_of(rows_of(regression, others, kept, noise_std));
    result.fractions.row(static_cast<Index>(i)) =
        (1.0 - known.diagonal().tail(k).cwiseQuotient(total).array()).cwiseMax(0.0).matrix().transpose();
  }
  return result;
}

void add_terms_left_out(SensorPosterior& posterior, const Eigen::Ref<const VectorXd>& widening) {
  posterior.covariance = widening.asDiagonal() * posterior.covariance * widening.asDiagonal();
  const Eigen::RowVectorXd rest = widening.cwiseAbs2().cwiseInverse().transpose();
  const Index num_sources = posterior.fractions.rows();
  posterior.fractions *= rest.asDiagonal();
  posterior.fractions.conservativeResize(num_sources + 1, Eigen::NoChange);
  posterior.fractions.row(num_sources) = (1.0 - rest.array()).matrix();
  posterior.sources.emplace_back("terms left out");
}

}  // namespace ident
