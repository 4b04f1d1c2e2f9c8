#include "ident/validate/independent_rows.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/filter/fft.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// sum_t x_t x_(t+l) for l = 0 .. n-1.
VectorXd lagged_products(const VectorXd& x) {
  const Index n = x.size(), length = dsp::good_fft_size(2 * n);
  VectorXd padded = VectorXd::Zero(length);
  padded.head(n) = x;
  const dsp::RealFft fft(length);
  const Eigen::VectorXcd X = fft.forward(padded);
  return fft.inverse(X.cwiseAbs2().cast<std::complex<double>>()).head(n);
}

}  // namespace

double independent_fraction(const Eigen::Ref<const VectorXd>& residual, const std::vector<Index>& samples) {
  const auto n = static_cast<double>(residual.size());
  if (residual.size() < 3 || residual.isZero(0.0)) return 1.0;
  const double unit = residual.cwiseAbs().maxCoeff();  // squares of smaller ones may vanish
  const Index first = samples.front(), length = samples.back() - first + 1;
  VectorXd series = VectorXd::Zero(length), mask = VectorXd::Zero(length);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    series(samples[i] - first) = residual(static_cast<Index>(i)) / unit;
    mask(samples[i] - first) = 1.0;
  }
  const VectorXd products = lagged_products(series), pairs = lagged_products(mask);
  const double variance = products(0) / n;
  double sum = 0.0;
  for (Index lag = 1; lag < length; ++lag) {
    const double count = std::round(pairs(lag));
    if (count < 1.0) continue;
    const double r = products(lag) / count / variance, square = std::min(r * r, 1.0);
    if (square > 2.0 * std::log(n) / count) sum += count / n * square;
  }
  return 1.0 / (1.0 + 2.0 * sum);
}

}  // namespace ident
