#include "ident/switches/interpolant.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "dsp/filter/kaiser.hpp"

namespace ident {
namespace {

using Eigen::Index;

constexpr Index oversampling = 8;
constexpr Index half_width = 24;  // samples either side; with this beta: flat to 0.85 of Nyquist within 1e-4
constexpr double beta = 9.0;

/// Taps x phase: what sample -half_width+1 ... half_width around a point `phase / num_phases` past sample 0 contribute;
/// the last phase is sample 1.
Eigen::MatrixXd phase_taps(Index num_phases) {
  const dsp::KaiserWindow window(beta);
  Eigen::MatrixXd taps(2 * half_width, num_phases + 1);
  for (Index phase = 0; phase <= num_phases; ++phase) {
    for (Index i = 0; i < taps.rows(); ++i) {
      const double distance =
          static_cast<double>(phase) / static_cast<double>(num_phases) - static_cast<double>(i - half_width + 1);
      const double angle = std::numbers::pi * distance;
      taps(i, phase) = (angle == 0.0 ? 1.0 : std::sin(angle) / angle) * window(distance / half_width);
    }
    taps.col(phase) /= taps.col(phase).sum();
  }
  return taps;
}

double reflected(const Eigen::Ref<const Eigen::VectorXd>& samples, Index i) {
  const Index end = samples.size() - 1;
  if (i < 0) return 2.0 * samples(0) - samples(std::min(-i, end));
  if (i > end) return 2.0 * samples(end) - samples(std::max<Index>(2 * end - i, 0));
  return samples(i);
}

}  // namespace

double interpolate(const Eigen::Ref<const Eigen::VectorXd>& samples, double at) {
  constexpr Index phases = 512;  // linear between them: 2e-6 of what lies at the Nyquist frequency
  static const Eigen::MatrixXd taps = phase_taps(phases);
  const double floor = std::floor(at), fine = (at - floor) * phases;
  const auto first = static_cast<Index>(floor) - half_width + 1;
  const Index phase = std::min(static_cast<Index>(fine), phases - 1);
  const double u = fine - static_cast<double>(phase);
  if (first >= 0 && first + taps.rows() <= samples.size()) {
    const auto window = samples.segment(first, taps.rows());
    const double here = taps.col(phase).dot(window);
    return u == 0.0 ? here : (1.0 - u) * here + u * taps.col(phase + 1).dot(window);
  }
  double sum = 0.0;
  for (Index k = 0; k < taps.rows(); ++k)
    sum += ((1.0 - u) * taps(k, phase) + u * taps(k, phase + 1)) * reflected(samples, first + k);
  return sum;
}

Interpolant::Interpolant(const Eigen::Ref<const Eigen::VectorXd>& samples, double sample_rate_hz, Index first,
                         Index last)
    : fine_rate_hz_(oversampling * sample_rate_hz), start_s_(static_cast<double>(first) / sample_rate_hz) {
  if (first < 0 || last > samples.size() || first >= last)
    throw std::invalid_argument("Interpolant: empty range, or outside the record");
  static const Eigen::MatrixXd taps = phase_taps(oversampling);
  const Index num_fine = (last - first - 1) * oversampling + 1;
  fine_.resize(num_fine);
  Eigen::VectorXd window(2 * half_width);
  for (Index i = first; i < last; ++i) {
    for (Index k = 0; k < window.size(); ++k) window(k) = reflected(samples, i - half_width + 1 + k);
    const Index fine_index = (i - first) * oversampling;
    for (Index phase = 0; phase < oversampling && fine_index + phase < num_fine; ++phase)
      fine_(fine_index + phase) = phase == 0 ? samples(i) : taps.col(phase).dot(window);
  }
  slope_ = Eigen::VectorXd::Zero(num_fine);
  for (Index i = 0; i < num_fine; ++i) {
    const auto at_clamped = [&](Index j) { return fine_(std::clamp<Index>(j, 0, num_fine - 1)); };
    const bool inside = i >= 2 && i + 2 < num_fine;
    slope_(i) = inside ? (8.0 * (fine_(i + 1) - fine_(i - 1)) - (fine_(i + 2) - fine_(i - 2))) / 12.0
                       : (at_clamped(i + 1) - at_clamped(i - 1)) / (i > 0 && i + 1 < num_fine ? 2.0 : 1.0);
  }
}

double Interpolant::at(double t_s) const {
  const double position = (t_s - start_s_) * fine_rate_hz_;
  if (!(position > 0.0)) return fine_(0);
  if (position >= static_cast<double>(fine_.size() - 1)) return fine_(fine_.size() - 1);
  const auto i = static_cast<Index>(position);
  const double u = position - static_cast<double>(i), w = 1.0 - u;
  return w * w * ((1.0 + 2.0 * u) * fine_(i) + u * slope_(i)) +
         u * u * ((1.0 + 2.0 * w) * fine_(i + 1) - w * slope_(i + 1));
}

}  // namespace ident
