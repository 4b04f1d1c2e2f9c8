#include "dsp/filter/short_low_pass.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "dsp/filter/kaiser.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double usual_attenuation_db = 40.0, transition_fraction = 0.4;  // width of the transition / cut-off
constexpr Index fine = 64;                                                // points of the grid a sample

double kernel(const KaiserWindow& window, double t, double reach, double cycles_per_sample) {
  if (std::abs(t) >= reach) return 0.0;
  const double phase = 2.0 * std::numbers::pi * cycles_per_sample * t;
  const double sinc = std::abs(phase) < 1e-9 ? 1.0 : std::sin(phase) / phase;
  return sinc * window(t / reach);
}

}  // namespace

ShortLowPass::ShortLowPass(double cutoff_hz, double sample_rate_hz)
    : ShortLowPass(cutoff_hz, transition_fraction * cutoff_hz, usual_attenuation_db, sample_rate_hz) {
  if (!(cutoff_hz < sample_rate_hz / 2.0))
    throw std::invalid_argument("ShortLowPass: 0 < cutoff_hz < sample_rate_hz / 2 is required");
}

ShortLowPass::ShortLowPass(double cutoff_hz, double transition_hz, double attenuation_db, double sample_rate_hz) {
  if (!(cutoff_hz > 0.0) || !(cutoff_hz <= sample_rate_hz / 2.0) || !(transition_hz > 0.0))
    throw std::invalid_argument("ShortLowPass: a cut-off in (0, sample_rate_hz / 2] and a transition are required");
  const double cutoff = cutoff_hz / sample_rate_hz;
  const KaiserWindow window(kaiser_beta(attenuation_db));
  const double length = kaiser_length(attenuation_db, transition_hz / sample_rate_hz, 1.0);
  reach_ = std::max<Index>(1, static_cast<Index>(std::ceil(length / 2.0)));
  const auto reach = static_cast<double>(reach_);

  taps_ = VectorXd::NullaryExpr(
      2 * reach_ + 1, [&](Index i) { return kernel(window, static_cast<double>(i - reach_), reach, cutoff); });
  taps_ /= taps_.sum();

  // Integrated once, twice, three times by the trapezoidal rule: t^k switched on is k! times the (k + 1)-fold integral.
  const Index n = 2 * reach_ * fine + 1;
  VectorXd integral = VectorXd::NullaryExpr(
      n, [&](Index i) { return kernel(window, static_cast<double>(i) / fine - reach, reach, cutoff); });
  integral /= integral.sum() / static_cast<double>(fine);
  switched_.resize(n, 3);
  for (int power = 0; power < 3; ++power) {
    double sum = 0.0, before = 0.0;
    for (double& value : integral) {
      sum += 0.5 * (before + value) / fine;
      before = std::exchange(value, sum);
    }
    switched_.col(power) = integral * (power == 2 ? 2.0 : 1.0);
  }
  second_moment_ = switched_(n - 1, 2) - reach * reach;
}

double ShortLowPass::stops_from_hz(double cutoff_hz) {
  return (1.0 + 0.5 * transition_fraction) * cutoff_hz;
}

VectorXd ShortLowPass::operator()(const VectorXd& signal, Index first, Index count) const {
  VectorXd result(count);
  for (Index i = 0; i < count; ++i) result(i) = taps_.dot(signal.segment(first + i - reach_, taps_.size()));
  return result;
}

double ShortLowPass::passed(int power, double t) const {
  return power == 0 ? 1.0 : power == 1 ? t : t * t + second_moment_;
}

double ShortLowPass::switched_on(int power, double t) const {
  const double position = (t + static_cast<double>(reach_)) * fine;
  if (position <= 0.0) return 0.0;
  const auto below = static_cast<Index>(position);
  if (below + 1 >= switched_.rows()) return passed(power, t);
  const double fraction = position - static_cast<double>(below);
  return (1.0 - fraction) * switched_(below, power) + fraction * switched_(below + 1, power);
}

}  // namespace dsp
