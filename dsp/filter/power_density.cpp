#include "dsp/filter/power_density.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "dsp/filter/fft.hpp"
#include "dsp/values/order_statistics.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The median of a mean of exponentially distributed ordinates, as a fraction of what it is the mean of: ln 2 of one,
/// by Wilson and Hilferty of several.
double median_of_mean(Index count) {
  return count == 1 ? std::numbers::ln2 : std::pow(1.0 - 1.0 / (9.0 * static_cast<double>(count)), 3);
}

/// |Y|^2 of a transform X of an even number of samples, Y being that of the same under Hann's window: each ordinate
/// with its neighbours, 1/2 - 1/4 exp(i pi / n) - 1/4 exp(-i pi / n) as the window has them.
void add_power_under_window(const Eigen::VectorXcd& X, VectorXd& power) {
  const Index end = X.size() - 1;
  const std::complex<double> turn = std::polar(0.25, std::numbers::pi / static_cast<double>(2 * end));
  for (Index k = 0; k <= end; ++k) {
    const std::complex<double> before = k > 0 ? X(k - 1) : std::conj(X(1)),
                               behind = k < end ? X(k + 1) : std::conj(before);
    power(k) += std::norm(0.5 * X(k) - turn * before - std::conj(turn) * behind);
  }
}

}  // namespace

PowerDensity::PowerDensity(Index num_samples, double rate_hz, Index piece_samples) : end_hz_(0.45 * rate_hz) {
  constexpr Index fewest = 8;
  if (num_samples < fewest) return;
  if (piece_samples > 0) num_pieces_ = std::max<Index>(1, num_samples / piece_samples);
  // Of a prime of a hundred thousand samples a transform takes four times as long, and the few left out tell nothing
  // that the others do not.
  length_ = good_fft_size_within(num_samples / num_pieces_);
  step_hz_ = rate_hz / static_cast<double>(length_);
}

PowerDensity::PowerDensity(const Eigen::Ref<const VectorXd>& signal, double rate_hz, Index piece_samples)
    : PowerDensity(signal.size(), rate_hz, piece_samples) {
  Eigen::VectorXcd X;
  for (Index piece = 0; length_ > 0 && piece < num_pieces_; ++piece) {
    const auto values = signal.segment(piece * length_, length_);
    add(values.array() - values.mean(), X);
  }
  normalise(rate_hz);
}

PowerDensity::PowerDensity(VectorXd&& signal, double rate_hz) : PowerDensity(signal.size(), rate_hz, 0) {
  if (length_ == 0) return;
  signal.conservativeResize(length_);
  signal.array() -= signal.mean();
  Eigen::VectorXcd X;
  add(std::move(signal), X);
  normalise(rate_hz);
}

void PowerDensity::add(VectorXd piece, Eigen::VectorXcd& X) {
  RealFft(length_).forward(piece, X);
  piece.resize(0);  // before there are ordinates
  if (density_.size() == 0) density_ = VectorXd::Zero(X.size());
  add_power_under_window(X, density_);
}

void PowerDensity::normalise(double rate_hz) {
  density_ *= 2.0 / (rate_hz * hann_power * static_cast<double>(length_ * num_pieces_));
}

double PowerDensity::between(double from_hz, double to_hz, Index least) const {
  if (density_.size() == 0) return 0.0;
  const auto first = std::max<Index>(1, static_cast<Index>(std::ceil(from_hz / step_hz_))),
             last = static_cast<Index>(std::floor(std::min(to_hz, end_hz_) / step_hz_));
  if (last - first + 1 < least) return 0.0;
  return median({density_.data() + first, density_.data() + last + 1}) / median_of_mean(num_pieces_);
}

}  // namespace dsp
