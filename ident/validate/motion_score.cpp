#include "ident/validate/motion_score.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "dsp/values/linear.hpp"
#include "ident/ranges/rows_of_terms.hpp"
#include "ident/sensors/channel_noise.hpp"
#include "ident/validate/regressor_noise.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Hann's window w of n samples makes neighbouring frequencies alike: the variance of a sum of products over them beside
// that of independent ones, n sum w^4 / (sum w^2)^2.
constexpr double window_variance = 35.0 / 18.0;

/// One-sided density of noise in the residual, from its power below frequencies in equal steps.
class Density {
 public:
  Density(const Model& model, std::size_t recording, const std::vector<Row>& rows,
          const std::vector<Columns>& recordings, double to_hz)
      : step_hz_(to_hz / steps),
        below_(noise_below(model, recording, rows, recordings, VectorXd::LinSpaced(steps + 1, 0.0, to_hz))) {}
  [[nodiscard]] double at(double f_hz) const {
    const Index i = std::min(static_cast<Index>(f_hz / step_hz_), steps - 1);
    return std::max(0.0, below_(i + 1) - below_(i)) / step_hz_;
  }

 private:
  static constexpr Index steps = 64;  // it grows as f^4 at most: by 6 % in a step at the upper end
  double step_hz_;
  VectorXd below_;
};

double mean_square_of_target(const Model& model, const RowsOfTerms& columns,
                             const Eigen::Ref<const VectorXd>& residual) {
  const VectorXd mean = means_of(model);
  double sum = 0.0;
  columns.for_each_block([&](Index first, const MatrixXd& phi) {
    sum += (phi * mean + residual.segment(first, phi.rows())).squaredNorm();
  });
  return sum / static_cast<double>(residual.size());
}

}  // namespace

MotionScore::MotionScore(const Model& model, const std::vector<Row>& rows, const std::vector<Columns>& recordings,
                         const Eigen::Ref<const VectorXd>& residual) {
  std::vector<Index> terms;
  for (const ModelTerm& term : model.terms) terms.push_back(term.column);
  const RowsOfTerms columns(rows, recordings, terms);
  const double linear = sensor_linearity * mean_square_of_target(model, columns, residual);
  constexpr Index least = 4;  // frequencies: the reach of the window
  Index total = 0;
  std::map<std::size_t, Density> densities;
  for (Index first = 0, end = 0; first < std::ssize(rows); first = end) {
    end = end_of_stretch(rows, first, std::ssize(rows));
    const std::size_t recording = rows[static_cast<std::size_t>(first)].recording;
    const Columns& own = recordings[recording];
    if (own.noise == nullptr) continue;
    const Index length = dsp::good_fft_size_within(end - first);  // without the last few rows
    const double n = static_cast<double>(length), step_hz = own.signals->sample_rate_hz / n;
    const Index count = static_cast<Index>(own.noise->needed_hz() / step_hz) - 1;
    if (count < least) continue;
    if (densities.count(recording) == 0)
      densities.emplace(recording, Density(model, recording, rows, recordings, own.noise->needed_hz()));
    const Density& density = densities.at(recording);
    const double linear_density = linear / own.noise->needed_hz();
    Piece piece{first, dsp::RealFft(length), dsp::hann_window(length), VectorXd(count)};
    for (Index k = 0; k < count; ++k)
      // A real or imaginary part of a transform has a quarter of the density times the rate and the window's power.
      piece.weight(k) = 1.0 / std::sqrt(0.25 * (density.at(static_cast<double>(k + 1) * step_hz) + linear_density) *
                                        own.signals->sample_rate_hz * dsp::hann_power * n);
    total += count;
    pieces_.push_back(std::move(piece));
  }
  const Index k = std::ssize(terms);
  if (k == 0 || total <= k) return;
  MatrixXd all(2 * total, k);
  VectorXd column(std::ssize(rows));
  for (Index j = 0; j < k; ++j) {
    RowsOfTerms(rows, recordings, {terms[static_cast<std::size_t>(j)]}).read(0, column);
    all.col(j) = weighted(column);
  }
  kept_ = dsp::Qr(std::move(all)).basis();
  residual_ = weighted(residual);
  residual_ -= kept_ * (kept_.transpose() * residual_);
}

VectorXd MotionScore::weighted(const Eigen::Ref<const VectorXd>& series) const {
  Index total = 0, at = 0;
  for (const Piece& piece : pieces_) total += piece.weight.size();
  VectorXd result(2 * total);
  for (const Piece& piece : pieces_) {
    const auto values = series.segment(piece.first, piece.window.size());
    const Eigen::VectorXcd transform =
        piece.fft.forward((values.array() - values.mean()).matrix().cwiseProduct(piece.window));
    const auto count = piece.weight.size();
    result.segment(at, count) = piece.weight.cwiseProduct(transform.segment(1, count).real());
    result.segment(at + count, count) = piece.weight.cwiseProduct(transform.segment(1, count).imag());
    at += 2 * count;
  }
  return result;
}

MotionScore::Score MotionScore::of(const Eigen::Ref<const VectorXd>& series) const {
  constexpr double rounding = 1e-8;  // of a series that the kept terms make up
  VectorXd own = weighted(series);
  const double power = own.squaredNorm();
  own -= kept_ * (kept_.transpose() * own);
  if (!(own.squaredNorm() > rounding * power)) return {};
  const double product = own.dot(residual_) / own.norm();
  const double z = product / std::sqrt(window_variance), fraction = product * product / residual_.squaredNorm();
  const double num_independent = static_cast<double>(residual_.size() - kept_.cols()) / window_variance;
  return {z, fraction, std::min(z * z, -num_independent * std::log1p(-fraction))};
}

}  // namespace ident
