#include "ident/validate/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "dsp/filter/fft.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/linear.hpp"

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using dsp::nan;
// One fit in a hundred whose residual is noise is called coloured: the milder error of the two.
constexpr double level_of_whiteness = 0.01;

// P(sup |Brownian bridge| > z), the limit of the Kolmogorov-Smirnov statistic.
double kolmogorov_tail(double z) {
  if (z < 0.2) return 1.0;  // the alternating series converges slowly there, and the answer is 1 to 12 digits
  double tail = 0.0;
  for (int k = 1; k <= 100; ++k) tail += (k % 2 == 1 ? 2.0 : -2.0) * std::exp(-2.0 * k * k * z * z);
  return std::clamp(tail, 0.0, 1.0);
}

// The power of two that brings the largest magnitude to about 1: no square then overflows or vanishes, and no bit of a
// ratio changes.
double unit_scale(const Eigen::Ref<const VectorXd>& values) {
  const double largest = values.size() > 0 ? values.cwiseAbs().maxCoeff() : 0.0;
  constexpr int largest_exponent = std::numeric_limits<double>::max_exponent - 1;
  return largest > 0.0 && std::isfinite(largest) ? std::ldexp(1.0, std::min(-std::ilogb(largest), largest_exponent))
                                                 : 1.0;
}

}  // namespace

double nmse(const Eigen::Ref<const VectorXd>& predicted, const Eigen::Ref<const VectorXd>& actual) {
  const double scale = unit_scale(actual), size = (scale * actual).squaredNorm();
  return size > 0.0 ? (scale * predicted - scale * actual).squaredNorm() / size : nan;
}

double nmse_centred(const Eigen::Ref<const VectorXd>& predicted, const Eigen::Ref<const VectorXd>& actual) {
  if (actual.size() == 0) return nan;
  const double scale = unit_scale(actual);
  const VectorXd scaled = scale * actual;
  const double size = (scaled.array() - scaled.mean()).matrix().squaredNorm();
  // Below this the variation is the rounding of a constant.
  const double rounding = std::numeric_limits<double>::epsilon() * scaled.norm();
  return size > rounding * rounding ? (scale * predicted - scaled).squaredNorm() / size : nan;
}

VectorXd predictive_variance(const Eigen::Ref<const MatrixXd>& phi, const Eigen::Ref<const MatrixXd>& covariance,
                             double noise_variance) {
  if (phi.cols() == 0) return VectorXd::Constant(phi.rows(), noise_variance);
  return ((phi * covariance).cwiseProduct(phi).rowwise().sum().array() + noise_variance).matrix();
}

std::string_view fault_of(const BandFractions& bands) {
  constexpr double least = 0.92, most = 0.98;
  return bands.within_95 < least ? "too narrow" : bands.within_95 > most ? "too wide" : "";
}

BandFractions band_fractions(const Eigen::Ref<const VectorXd>& predicted, const Eigen::Ref<const VectorXd>& variance,
                             const Eigen::Ref<const VectorXd>& actual) {
  if (actual.size() == 0) return {nan, nan, nan};
  const auto z = ((actual - predicted).array().abs() / variance.array().sqrt()).eval();
  const auto fraction = [&](double quantile) {
    return static_cast<double>((z <= quantile).count()) / static_cast<double>(z.size());
  };
  return {fraction(0.67448975), fraction(1.64485363), fraction(1.95996398)};
}

Whiteness residual_whiteness(const Eigen::Ref<const VectorXd>& raw_residual, const std::vector<Index>& samples,
                             double sample_rate_hz, double band_hz) {
  Whiteness result;
  const VectorXd residual = unit_scale(raw_residual) * raw_residual;
  if (static_cast<std::size_t>(residual.size()) != samples.size())
    throw std::invalid_argument("residual_whiteness: as many residuals as samples");
  if (residual.size() < 32 || !(residual.squaredNorm() > 0.0)) return result;
  // Without the last few rows the transform is fast.
  const Index length = dsp::good_fft_size_within(samples.back() - samples.front() + 1);
  const auto num_rows =
      static_cast<Index>(std::lower_bound(samples.begin(), samples.end(), samples.front() + length) - samples.begin());
  VectorXd in_time = VectorXd::Zero(length);
  const double mean = residual.head(num_rows).mean();
  for (Index i = 0; i < num_rows; ++i)
    in_time(samples[static_cast<std::size_t>(i)] - samples.front()) = residual(i) - mean;
  const Eigen::VectorXcd spectrum = dsp::RealFft(length).forward(in_time);
  const auto end =
      std::min<Index>(spectrum.size() - 1, static_cast<Index>(band_hz / sample_rate_hz * static_cast<double>(length)));
  // Zeros in the gaps correlate neighbouring ordinates, of which as many are independent as there are rows.
  const double independent = static_cast<double>(end) * static_cast<double>(num_rows) / static_cast<double>(length);
  if (independent < 16.0) return result;

  VectorXd power = spectrum.segment(1, end).cwiseAbs2();
  const double total = power.sum();
  const double rounding = std::numeric_limits<double>::epsilon() * residual.norm();
  if (total <= static_cast<double>(length) * rounding * rounding) return result;  // a constant residual
  double cumulated = 0.0, largest = 0.0;
  for (Index k = 0; k < end; ++k) {
    cumulated += power(k) / total;
    largest = std::max(largest, std::abs(cumulated - static_cast<double>(k + 1) / static_cast<double>(end)));
  }
  result.tested = true;
  const double slope = kolmogorov_tail(largest * std::sqrt(independent));
  const double tone = static_cast<double>(end) * std::pow(1.0 - power.maxCoeff() / total, static_cast<double>(end - 1));
  result.p_value = std::min(1.0, 2.0 * std::min(slope, tone));
  const Index strongest = std::max<Index>(1, end / 20);
  std::partial_sort(power.begin(), power.begin() + strongest, power.end(), std::greater<>());
  result.peak_fraction = power.head(strongest).sum() / total;
  result.white = result.p_value >= level_of_whiteness;
  return result;
}

BlockScores::BlockScores(Index num_terms, Index num_rows)
    : num_rows_(num_rows), sums_(MatrixXd::Zero(num_terms, std::clamp<Index>(num_rows / 4, 1, 50))) {}

void BlockScores::add(const Eigen::Ref<const MatrixXd>& phi, const Eigen::Ref<const VectorXd>& residual) {
  const Index num_blocks = sums_.cols();
  for (Index done = 0; done < phi.rows();) {
    const Index row = next_row_ + done, block = ((row + 1) * num_blocks - 1) / num_rows_;
    const Index count = std::min((block + 1) * num_rows_ / num_blocks - row, phi.rows() - done);
    sums_.col(block) += phi.middleRows(done, count).transpose() * residual.segment(done, count);
    done += count;
  }
  next_row_ += phi.rows();
}

MatrixXd robust_covariance(const RFactor& kept, const BlockScores& scores) {
  const Index terms = kept.num_terms;
  if (terms == 0 || kept.num_samples <= terms) return {};
  const MatrixXd triangle = kept.R.topLeftCorner(terms, terms);
  const VectorXd scale = triangle.colwise().stableNorm();
  if (!(scale.minCoeff() > 0.0)) return {};
  const MatrixXd R = triangle * scale.cwiseInverse().asDiagonal();
  // (Phi'Phi)^-1 = R^-1 R^-T on columns of unit norm; the factor corrects for the few blocks.
  const MatrixXd scaled_sums = scale.cwiseInverse().asDiagonal() * scores.sums();
  const MatrixXd root = scale.cwiseInverse().asDiagonal() * dsp::solve_upper(R, dsp::solve_transposed(R, scaled_sums));
  const auto num_blocks = static_cast<double>(scores.sums().cols());
  return num_blocks / std::max(1.0, num_blocks - 1.0) * root * root.transpose();
}

}  // namespace ident
