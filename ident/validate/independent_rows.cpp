#include "ident/validate/independent_rows.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Adds sum_t x_t x_(t+l) for l = 0 .. length-1 to `sums`.
void add_lagged_products(const dsp::RealFft& fft, const VectorXd& padded, Index length, VectorXd& sums) {
  Eigen::VectorXcd X = fft.forward(padded);
  for (std::complex<double>& one : X) one = std::norm(one);
  sums.head(length) += fft.inverse(std::move(X)).head(length);
}

}  // namespace

IndependentRows::IndependentRows(const std::vector<Index>& samples, std::vector<Index> first_rows)
    : samples_(samples), chance_(2.0 * std::log(static_cast<double>(samples.size()))) {
  first_rows.push_back(std::ssize(samples));
  for (std::size_t r = 0; r + 1 < first_rows.size(); ++r) {
    const Index first = first_rows[r], count = first_rows[r + 1] - first;
    if (count <= 0) continue;
    const Index first_sample = samples[static_cast<std::size_t>(first)];
    records_.push_back(
        {first, count, first_sample, samples[static_cast<std::size_t>(first + count - 1)] - first_sample + 1});
  }
  Index longest = 0;
  for (const Record& record : records_) longest = std::max(longest, record.length);
  pairs_ = VectorXd::Zero(longest);
  if (longest == 0) return;
  fft_ = std::make_unique<dsp::RealFft>(dsp::good_fft_size(2 * longest));
  for (const Record& record : records_) {
    if (record.num_rows == record.length) {  // without a gap
      pairs_.head(record.length) += VectorXd::LinSpaced(record.length, static_cast<double>(record.length), 1.0);
      continue;
    }
    const VectorXd ones = VectorXd::Ones(std::ssize(samples_));
    add_lagged_products(*fft_, in_time(record, ones, fft_->size()), record.length, pairs_);
  }
  pairs_ = pairs_.array().round();
}

VectorXd IndependentRows::in_time(const Record& record, const Eigen::Ref<const VectorXd>& values, Index size) const {
  VectorXd series = VectorXd::Zero(size);
  for (Index i = record.first_row; i < record.first_row + record.num_rows; ++i)
    series(samples_[static_cast<std::size_t>(i)] - record.first_sample) = values(i);
  return series;
}

VectorXd IndependentRows::autocorrelation(const Eigen::Ref<const VectorXd>& residual) const {
  if (residual.size() < 3 || residual.isZero(0.0)) return {};
  const double unit = residual.cwiseAbs().maxCoeff();  // squares of smaller ones may vanish
  VectorXd products = VectorXd::Zero(pairs_.size());
  for (const Record& record : records_) {
    VectorXd series = in_time(record, residual, fft_->size());
    series /= unit;
    add_lagged_products(*fft_, series, record.length, products);
  }
  const double variance = products(0) / static_cast<double>(residual.size());
  const auto r = products.array() / pairs_.array().max(1.0) / variance;
  return (r.max(-1.0).min(1.0) * pairs_.array().min(1.0)).matrix();  // 0 where there is no pair
}

bool IndependentRows::within_chance(double r, Index lag) const {
  return r * r * pairs_(lag) <= chance_;
}

double IndependentRows::fraction_by(const VectorXd& r, const VectorXd& other) const {
  const auto n = static_cast<double>(samples_.size());
  double sum = 0.0;
  for (Index lag = 1; lag < std::min(r.size(), other.size()); ++lag)
    if (!within_chance(r(lag), lag)) sum += pairs_(lag) / n * (r(lag) * other(lag));
  return 1.0 / (1.0 + 2.0 * std::max(0.0, sum));
}

double IndependentRows::fraction(const Eigen::Ref<const VectorXd>& residual) const {
  return fraction_by(autocorrelation(residual));
}

double IndependentRows::fraction_beside(const VectorXd& r, const Eigen::Ref<const VectorXd>& values) const {
  if (values.size() < 3 || values.isZero(0.0)) return 1.0;
  std::vector<Index> lags;  // all others count as none
  for (Index lag = 1; lag < r.size(); ++lag)
    if (!within_chance(r(lag), lag)) lags.push_back(lag);
  constexpr std::size_t few = 32;  // two products a row and lag are less work than two transforms of twice the length
  if (lags.size() > few) return fraction_by(r, autocorrelation(values));
  VectorXd other = VectorXd::Zero(r.size());
  const double unit = values.cwiseAbs().maxCoeff(),
               variance = (values / unit).squaredNorm() / static_cast<double>(values.size());
  for (const Record& record : records_) {
    VectorXd series = in_time(record, values, record.length);
    series /= unit;
    for (const Index lag : lags)
      if (lag < record.length) other(lag) += series.head(record.length - lag).dot(series.tail(record.length - lag));
  }
  for (const Index lag : lags) other(lag) = std::clamp(other(lag) / pairs_(lag) / variance, -1.0, 1.0);
  return fraction_by(r, other);
}

Index IndependentRows::first_lag_within_chance(const VectorXd& r) const {
  for (Index lag = 1; lag < r.size(); ++lag)
    if (within_chance(r(lag), lag)) return lag;
  return std::max<Index>(1, r.size());
}

double independent_fraction(const Eigen::Ref<const VectorXd>& residual, const std::vector<Index>& samples) {
  return IndependentRows(samples).fraction(residual);
}

}  // namespace ident
