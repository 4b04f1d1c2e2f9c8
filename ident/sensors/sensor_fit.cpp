#include "ident/sensors/sensor_fit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dsp/values/linear.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Covariance of the unknowns of least squares on these rows of unit variance: (A'A)^-1, columns at unit norm inside.
MatrixXd covariance_of(const MatrixXd& rows) {
  const VectorXd scale = rows.colwise().norm().transpose().cwiseMax(std::numeric_limits<double>::min());
  const MatrixXd R = triangle(rows * scale.cwiseInverse().asDiagonal());
  const MatrixXd root = dsp::inverse_of_upper(R);
  const MatrixXd scaled = scale.cwiseInverse().asDiagonal() * root;
  return scaled * scaled.transpose();
}

/// The regression with sensors in units of their priors, candidates at unit norm and the target's norm as its unit: no
/// square overflows or vanishes, whatever the units of the data.
struct Scaled {
  MatrixXd R;
  VectorXd scale;  ///< what the columns were divided by; of sensors: target / (their value)
  double unit;     ///< of the target

  explicit Scaled(const SensorRegression& regression) : R(regression.joint.R), scale(R.cols()) {
    const Index n_s = regression.num_sensors();
    for (Index i = n_s; i < R.cols(); ++i) {
      const double norm = R.col(i).stableNorm();
      scale(i) = norm > 0.0 ? norm : 1.0;
    }
    unit = scale(R.cols() - 1);
    for (Index i = 0; i < n_s; ++i) {
      scale(i) = unit / regression.prior_std(i);
      R.col(i) *= regression.prior_std(i) / unit;
    }
    for (Index i = n_s; i < R.cols(); ++i) R.col(i) /= scale(i);
  }
};

/// The rows over the noise, above those of the priors, for these sensor columns and candidates.
MatrixXd rows_of(const Scaled& data, Index num_sensors, const std::vector<Index>& sensors,
                 const std::vector<Index>& kept, double noise) {
  const auto n_s = static_cast<Index>(sensors.size()), k = static_cast<Index>(kept.size()), height = data.R.rows();
  MatrixXd rows = MatrixXd::Zero(height + n_s, n_s + k);
  for (Index i = 0; i < n_s; ++i) {
    rows.col(i).head(height) = data.R.col(sensors[static_cast<std::size_t>(i)]) / noise;
    rows(height + i, i) = 1.0;
  }
  for (Index j = 0; j < k; ++j)
    rows.col(n_s + j).head(height) = data.R.col(num_sensors + kept[static_cast<std::size_t>(j)]) / noise;
  return rows;
}

/// R of the candidates and the target behind the sensors.
MatrixXd behind_sensors(const Scaled& data, Index num_sensors, double noise) {
  const Index width = data.R.cols() - num_sensors;
  MatrixXd rows = MatrixXd::Zero(data.R.rows() + num_sensors, data.R.cols());
  rows.topRows(data.R.rows()) = data.R;
  rows.bottomLeftCorner(num_sensors, num_sensors).diagonal().setConstant(noise);
  return triangle(rows).bottomRightCorner(width, width);
}

std::vector<Index> sensors_but(const SensorRegression& regression, const std::string& source) {
  std::vector<Index> left;
  for (Index i = 0; i < regression.num_sensors(); ++i)
    if (regression.sources[static_cast<std::size_t>(i)] != source) left.push_back(i);
  return left;
}

}  // namespace

void add_rows(SensorRegression& regression, const Eigen::Ref<const MatrixXd>& rows) {
  if (rows.rows() == 0) return;
  const MatrixXd& R = regression.joint.R;
  MatrixXd all(R.rows() + rows.rows(), R.cols());
  all << R, rows;
  regression.joint.R = triangle(all);
}

RFactor without_sensors(const SensorRegression& regression, double noise_std) {
  const Scaled data(regression);
  MatrixXd R = behind_sensors(data, regression.num_sensors(), noise_std / data.unit);
  const Index width = R.cols();
  R *= data.scale.tail(width).asDiagonal();
  return {std::move(R), width - 1, regression.joint.num_samples};
}

double noise_beside_all(const SensorRegression& regression) {
  const Scaled data(regression);
  const Index b = data.R.cols() - 1 - regression.num_sensors();
  const double rows_to_spare = std::max(1.0, static_cast<double>(regression.joint.num_samples - b));
  // From above, as without sensors: unheld by their priors, the gains of two accelerometers make up any target.
  double noise = std::abs(triangle(data.R.rightCols(b + 1))(b, b)) / std::sqrt(rows_to_spare);
  constexpr int most_passes = 20;
  constexpr double close = 1e-3;  // of the noise, of which 10^4 rows tell 7e-3
  for (int pass = 0; pass < most_passes; ++pass) {
    const MatrixXd R = behind_sensors(data, regression.num_sensors(), noise);
    const double before = std::exchange(noise, std::abs(R(b, b)) / std::sqrt(rows_to_spare));
    if (noise >= (1.0 - close) * before) break;
  }
  return noise * data.unit;
}

VectorXd sensor_mean(const SensorRegression& regression, const std::vector<Index>& kept,
                     const Eigen::Ref<const VectorXd>& mean, double noise_std) {
  const Scaled data(regression);
  const Index n_s = regression.num_sensors(), height = data.R.rows();
  MatrixXd rows = MatrixXd::Zero(height + n_s, n_s);
  rows.topRows(height) = data.R.leftCols(n_s);
  rows.bottomRows(n_s).diagonal().setConstant(noise_std / data.unit);
  VectorXd left = VectorXd::Zero(height + n_s);
  left.head(height) = data.R.rightCols(1);
  for (Index j = 0; j < mean.size(); ++j) {
    const Index column = n_s + kept[static_cast<std::size_t>(j)];
    left.head(height) -= mean(j) * (data.scale(column) / data.unit) * data.R.col(column);
  }
  return regression.prior_std.cwiseProduct(dsp::least_squares(rows, left));
}

SensorPosterior sensor_posterior(const SensorRegression& regression, const std::vector<Index>& kept,
                                 const Eigen::Ref<const VectorXd>& mean, double noise_std,
                                 double independent_fraction) {
  const Scaled data(regression);
  const Index n_s = regression.num_sensors(), k = static_cast<Index>(kept.size());
  const std::vector<Index> all = sensors_but(regression, "");
  const double white = noise_std / data.unit, noise = white / std::sqrt(independent_fraction);
  VectorXd unit(k);  // of the coefficients
  for (Index j = 0; j < k; ++j) unit(j) = data.unit / data.scale(n_s + kept[static_cast<std::size_t>(j)]);
  SensorPosterior result;
  result.noise_std = noise_std;
  const MatrixXd joint = covariance_of(rows_of(data, n_s, all, kept, noise));
  VectorXd units(n_s + k);
  units << regression.prior_std, unit;
  result.joint = units.asDiagonal() * joint * units.asDiagonal();
  result.covariance = result.joint.bottomRightCorner(k, k);
  result.noise_covariance = unit.asDiagonal() * covariance_of(rows_of(data, n_s, {}, kept, noise)) * unit.asDiagonal();
  result.sensor_std = joint.diagonal().head(n_s).cwiseSqrt().cwiseProduct(regression.prior_std);
  result.sensor_mean = sensor_mean(regression, kept, mean, noise * data.unit);

  result.sources = {"noise"};
  for (const std::string& source : regression.sources)
    if (std::find(result.sources.begin(), result.sources.end(), source) == result.sources.end())
      result.sources.push_back(source);
  result.fractions.resize(static_cast<Index>(result.sources.size()), k);
  const VectorXd total = joint.diagonal().tail(k);
  result.fractions.row(0) =
      covariance_of(rows_of(data, n_s, {}, kept, noise)).diagonal().cwiseQuotient(total).transpose();
  for (std::size_t i = 1; i < result.sources.size(); ++i) {
    const std::vector<Index> others = sensors_but(regression, result.sources[i]);
    const MatrixXd known = covariance_of(rows_of(data, n_s, others, kept, noise));
    result.fractions.row(static_cast<Index>(i)) =
        (1.0 - known.diagonal().tail(k).cwiseQuotient(total).array()).cwiseMax(0.0).matrix().transpose();
  }
  return result;
}

std::vector<SensorTwin> sensor_twins(const SensorRegression& regression, const std::vector<Index>& kept) {
  // Cosine of the angle between them: what is left of either beside the other is below a hundredth of its power.
  constexpr double same = 0.995;
  constexpr double rounding = 1e-6;  // of a column, beyond the kept ones
  const Scaled data(regression);
  const Index n_s = regression.num_sensors(), b = data.R.cols() - 1 - n_s;
  std::vector<SensorTwin> twins;
  for (Index j = 0; j < b; ++j) {
    MatrixXd others(data.R.rows(), 0);
    for (const Index term : kept) {
      if (term == j) continue;
      others.conservativeResize(Eigen::NoChange, others.cols() + 1);
      others.rightCols(1) = data.R.col(n_s + term);
    }
    MatrixXd beyond(data.R.rows(), n_s + 1);
    beyond << data.R.leftCols(n_s), data.R.col(n_s + j);
    const VectorXd whole = beyond.colwise().norm();
    if (others.cols() > 0) {
      dsp::Qr(others).rotate(beyond);
      beyond.topRows(others.cols()).setZero();
    }
    const VectorXd left = beyond.colwise().norm();
    for (Index s = 0; s < n_s; ++s)
      if (left(s) > rounding * whole(s) && left(n_s) > rounding * whole(n_s) &&
          std::abs(beyond.col(s).dot(beyond.col(n_s))) > same * left(s) * left(n_s))
        twins.push_back({s, j});
  }
  // A sensor that is the same as each of several terms beyond the others scales the whole equation.
  std::vector<int> count(static_cast<std::size_t>(n_s), 0);
  for (const SensorTwin& twin : twins) ++count[static_cast<std::size_t>(twin.sensor)];
  std::erase_if(twins, [&](const SensorTwin& twin) { return count[static_cast<std::size_t>(twin.sensor)] > 1; });
  return twins;
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
