#include "dsp/filter/kink_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>

#include "dsp/filter/dispatch.hpp"
#include "dsp/filter/lanes.hpp"

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

// Cubic interpolation between rows of a table, its values and slopes in turn, at |from|, |from + 1 by|, ... rows.
struct Table {
  const double* rows;
  Index last;  // row at which an interval may begin
};

ARDENT_DISPATCH void add_interpolated(const Table& table, double weight, double from, double by, Index count,
                                      double* out) {
  typedef std::int64_t Bits __attribute__((vector_size(4 * sizeof(std::int64_t))));
  typedef std::int32_t Integers __attribute__((vector_size(4 * sizeof(std::int32_t))));
  for (Index i = 0; i < count; i += 4) {
    const Lanes index = static_cast<double>(i) + Lanes{0.0, 1.0, 2.0, 3.0};
    const Lanes at = reinterpret_cast<Lanes>(reinterpret_cast<Bits>(from + by * index) & INT64_MAX);
    const Integers row = __builtin_convertvector(at, Integers);
    Lanes cells[4];
    for (int lane = 0; lane < 4; ++lane)
      cells[lane] = *reinterpret_cast<const UnalignedLanes*>(table.rows + 2 * std::min<Index>(row[lane], table.last));
    const Lanes a = __builtin_shufflevector(cells[0], cells[1], 0, 4, 2, 6),
                b = __builtin_shufflevector(cells[0], cells[1], 1, 5, 3, 7),
                c = __builtin_shufflevector(cells[2], cells[3], 0, 4, 2, 6),
                d = __builtin_shufflevector(cells[2], cells[3], 1, 5, 3, 7);
    const Lanes value = __builtin_shufflevector(a, c, 0, 1, 4, 5),
                next_value = __builtin_shufflevector(a, c, 2, 3, 6, 7),
                slope = __builtin_shufflevector(b, d, 0, 1, 4, 5),
                next_slope = __builtin_shufflevector(b, d, 2, 3, 6, 7);
    const Lanes u = at - __builtin_convertvector(row, Lanes), w = 1.0 - u;
    const Lanes sum = weight * (w * w * ((1.0 + 2.0 * u) * value + u * slope) +
                                u * u * ((1.0 + 2.0 * w) * next_value - w * next_slope));
    if (i + 4 <= count)
      *reinterpret_cast<UnalignedLanes*>(out + i) += sum;
    else
      for (Index lane = 0; i + lane < count; ++lane) out[i + lane] += sum[lane];
  }
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
  both_.resize(2, kept);
  both_ << value_.transpose(), step_s_ * slope_.transpose();
}

void KinkKernel::add(double weight, double tau_s, double spacing_s, Eigen::Ref<Eigen::VectorXd> values) const {
  add_interpolated({both_.data(), both_.cols() - 2}, weight, tau_s / step_s_, spacing_s / step_s_, values.size(),
                   values.data());
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
