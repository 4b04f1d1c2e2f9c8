#include "dsp/filter/kink_kernel.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace dsp {
namespace {

using Eigen::Index;

/// Impulse response of the band: the raised-cosine pulse.
double pulse(const SpectralBand& band, double tau_s) {
  const double width_hz = band.cutoff_hz + band.rolloff_hz, edge_hz = band.cutoff_hz - band.rolloff_hz;
  const double angle = std::numbers::pi * width_hz * tau_s, rest = 1.0 - std::pow(2.0 * edge_hz * tau_s, 2);
  const double sinc = angle == 0.0 ? 1.0 : std::sin(angle) / angle;
  // Where `rest` is zero so is the cosine; their ratio there is pi / 4.
  const double roll =
      std::abs(rest) < 1e-9 ? std::numbers::pi / 4.0 : std::cos(std::numbers::pi * edge_hz * tau_s) / rest;
  return width_hz * sinc * roll;
}

}  // namespace

KinkKernel::KinkKernel(const SpectralBand& band) {
  if (!(band.rolloff_hz > 0.0) || !(band.cutoff_hz > band.rolloff_hz))
    throw std::invalid_argument("KinkKernel: 0 < rolloff_hz < cutoff_hz is required");
  constexpr double reach_edges = 4.0;       // what is left there moves a zero by less than a microsecond
  constexpr double far_edges = 16.0;        // the band's impulse response there: 1e-5 of its crest
  constexpr double steps_per_wave = 128.0;  // of the cut-off: cubic interpolation between them is exact to 1e-7
  reach_s_ = reach_edges / (band.cutoff_hz - band.rolloff_hz);
  step_s_ = 1.0 / (steps_per_wave * band.cutoff_hz);
  const auto kept = static_cast<Index>(std::ceil(reach_s_ / step_s_)) + 1;
  const auto far = static_cast<Index>(std::ceil(far_edges / reach_edges * reach_s_ / step_s_)) + 1;
  // K'' is a pulse of unit area less the band's own: integrated twice from afar, where K and K' are zero.
  value_.setZero(far);
  slope_.setZero(far);
  double after = pulse(band, static_cast<double>(far - 1) * step_s_);
  for (Index i = far - 2; i >= 0; --i) {
    const double t = static_cast<double>(i) * step_s_, here = pulse(band, t);
    const double area = step_s_ / 6.0 * (here + 4.0 * pulse(band, t + 0.5 * step_s_) + after);
    slope_(i) = slope_(i + 1) + area;
    // The slope's cubic through both ends and its derivatives there, -here and -after, integrated.
    value_(i) = value_(i + 1) - step_s_ * (0.5 * (slope_(i) + slope_(i + 1)) + step_s_ * (after - here) / 12.0);
    after = here;
  }
  value_.conservativeResize(kept);
  slope_.conservativeResize(kept);
}

double KinkKernel::operator()(double tau_s) const {
  const double at = std::abs(tau_s) / step_s_;
  const auto i = static_cast<Index>(at);
  if (i + 1 >= value_.size()) return 0.0;
  const double u = at - static_cast<double>(i), w = 1.0 - u;
  return w * w * ((1.0 + 2.0 * u) * value_(i) + u * step_s_ * slope_(i)) +
         u * u * ((1.0 + 2.0 * w) * value_(i + 1) - w * step_s_ * slope_(i + 1));
}

double KinkKernel::slope(double tau_s) const {
  const double at = std::abs(tau_s) / step_s_;
  const auto i = static_cast<Index>(at);
  if (tau_s == 0.0 || i + 1 >= slope_.size()) return 0.0;
  const double u = at - static_cast<double>(i);
  const double slope = (1.0 - u) * slope_(i) + u * slope_(i + 1);
  return tau_s < 0.0 ? -slope : slope;
}

}  // namespace dsp
