#include "ident/judge.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/fft.hpp"

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// P(sup |Brownian bridge| > z), the limit of the Kolmogorov-Smirnov statistic.
double kolmogorov_tail(double z) {
  if (z < 0.2) return 1.0;  // the alternating series converges slowly there, and the answer is 1 to 12 digits
  double tail = 0.0;
  for (int k = 1; k <= 100; ++k) tail += (k % 2 == 1 ? 2.0 : -2.0) * std::exp(-2.0 * k * k * z * z);
  return std::clamp(tail, 0.0, 1.0);
}

}  // namespace

double nmse(const Eigen::Ref<const VectorXd>& predicted, const Eigen::Ref<const VectorXd>& actual) {
  const double size = actual.squaredNorm();
  return size > 0.0 ? (predicted - actual).squaredNorm() / size : nan;
}

double nmse_centred(const Eigen::Ref<const VectorXd>& predicted, const Eigen::Ref<const VectorXd>& actual) {
  if (actual.size() == 0) return nan;
  const double size = (actual.array() - actual.mean()).matrix().squaredNorm();
  // Below this the variation is the rounding of a constant.
  const double rounding = std::numeric_limits<double>::epsilon() * actual.norm();
  return size > rounding * rounding ? (predicted - actual).squaredNorm() / size : nan;
}

VectorXd predictive_variance(const Eigen::Ref<const MatrixXd>& phi, const Eigen::Ref<const MatrixXd>& covariance,
                             double noise_variance) {
  if (phi.cols() == 0) return VectorXd::Constant(phi.rows(), noise_variance);
  return ((phi * covariance).cwiseProduct(phi).rowwise().sum().array() + noise_variance).matrix();
}

BandShares band_shares(const Eigen::Ref<const VectorXd>& predicted, const Eigen::Ref<const VectorXd>& variance,
                       const Eigen::Ref<const VectorXd>& actual) {
  if (actual.size() == 0) return {nan, nan, nan};
  const auto z = ((actual - predicted).array().abs() / variance.array().sqrt()).eval();
  const auto share = [&](double quantile) {
    return static_cast<double>((z <= quantile).count()) / static_cast<double>(z.size());
  };
  return {share(0.67448975), share(1.64485363), share(1.95996398)};
}

Whiteness residual_whiteness(const Eigen::Ref<const VectorXd>& residual, const std::vector<RowSpan>& spans,
                             double sample_rate_hz, double band_hz) {
  Whiteness result;
  // Each span is a record of its own; their periodograms are pooled on the grid of the longest one by laying the spans
  // end to end with zeros between, which leaves the periodogram of white noise flat.
  Index length = 0;
  for (const RowSpan& span : spans) length += span.last - span.first;
  if (length < 32 || !(residual.squaredNorm() > 0.0)) return result;
  const dsp::RealFft fft(length);
  const Eigen::VectorXcd spectrum = fft.forward(residual.head(length).array() - residual.head(length).mean());
  const auto end =
      std::min<Index>(spectrum.size() - 1, static_cast<Index>(band_hz / sample_rate_hz * static_cast<double>(length)));
  if (end < 16) return result;

  VectorXd power = spectrum.segment(1, end).cwiseAbs2();
  const double total = power.sum();
  double cumulated = 0.0, largest = 0.0;
  for (Index k = 0; k < end; ++k) {
    cumulated += power(k) / total;
    largest = std::max(largest, std::abs(cumulated - static_cast<double>(k + 1) / static_cast<double>(end)));
  }
  result.tested = true;
  result.num_frequencies = end;
  const double slope = kolmogorov_tail(largest * std::sqrt(static_cast<double>(end)));
  const double tone = static_cast<double>(end) * std::pow(1.0 - power.maxCoeff() / total, static_cast<double>(end - 1));
  result.p_value = std::min(1.0, 2.0 * std::min(slope, tone));
  const Index strongest = std::max<Index>(1, end / 20);
  std::sort(power.begin(), power.end(), std::greater<>());
  result.peak_share = power.head(strongest).sum() / total;
  result.white = result.p_value >= 0.001;
  return result;
}

MatrixXd robust_covariance(const Eigen::Ref<const MatrixXd>& phi, const Eigen::Ref<const VectorXd>& residual) {
  const Index rows = phi.rows(), terms = phi.cols();
  if (terms == 0 || rows <= terms) return {};
  const VectorXd scale = phi.colwise().stableNorm();
  if (!(scale.minCoeff() > 0.0)) return {};
  const MatrixXd unit = phi * scale.cwiseInverse().asDiagonal();
  const MatrixXd R = Eigen::HouseholderQR<MatrixXd>(unit).matrixQR().topRows(terms).triangularView<Eigen::Upper>();
  const Index num_blocks = std::clamp<Index>(rows / 4, 1, 50);
  MatrixXd sums = MatrixXd::Zero(terms, num_blocks);
  for (Index block = 0; block < num_blocks; ++block) {
    const Index first = block * rows / num_blocks, count = (block + 1) * rows / num_blocks - first;
    sums.col(block) = unit.middleRows(first, count).transpose() * residual.segment(first, count);
  }
  // (Phi'Phi)^-1 = R^-1 R^-T; the factor corrects for the few blocks.
  const auto upper = R.triangularView<Eigen::Upper>();
  MatrixXd root = upper.transpose().solve(sums);
  root = upper.solve(root);
  root = scale.cwiseInverse().asDiagonal() * root;
  const double correction = static_cast<double>(num_blocks) / std::max(1.0, static_cast<double>(num_blocks - 1));
  return correction * root * root.transpose();
}

std::vector<RowSpan> contiguous_spans(const std::vector<Index>& rows) {
  std::vector<RowSpan> spans;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto place = static_cast<Index>(i);
    if (i == 0 || rows[i] != rows[i - 1] + 1) spans.push_back({place, place});
    spans.back().last = place + 1;
  }
  return spans;
}

}  // namespace ident
