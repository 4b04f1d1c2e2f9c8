#include "dsp/regimes/joint_velocity.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "dsp/filter/power_density.hpp"
#include "dsp/regimes/half_cycles.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

double omega(double frequency_hz) {
  return 2.0 * std::numbers::pi * frequency_hz;
}

ExtendedSpectrum spectrum_of(const Motion& motion, const char* name) {
  return ExtendedSpectrum(motion.at(name), motion.sample_rate_hz);
}

/// v times one gain and the integral of a times another.
template <class GainOfV, class GainOfA>
VectorXd sum_of(ExtendedSpectrum v, const ExtendedSpectrum& a, const GainOfV& of_v, const GainOfA& of_a) {
  v.multiply(of_v);
  v.add(a, [&](double f) { return std::complex<double>(0.0, f > 0.0 ? -of_a(f) / omega(f) : 0.0); });
  return std::move(v).signal();
}

}  // namespace

JointVelocity::JointVelocity(const Motion& motion, const SpectralBand& band, double period_s)
    : band_(band),
      v_(spectrum_of(motion, "v")),
      step_hz_(1.0 / period_s),
      density_of_x_(density_beyond_harmonics(motion, motion.at("x"), period_s)),
      of_its_own_(!std::isfinite(motion.find("v")->flat_to_hz)) {
  if (of_its_own_) density_of_v_ = density_beyond_harmonics(motion, motion.at("v"), period_s);
  const Signal* a = motion.find("a");
  if (a == nullptr || std::isfinite(a->flat_to_hz)) return;  // computed, it has nothing of its own to say
  a_ = spectrum_of(motion, "a");
  VectorXd difference = sum_of(
      v_, *a_, [](double) { return 1.0; }, [](double) { return -1.0; });
  for (std::size_t i = 0; i < motion.excluded.size(); ++i)
    if (motion.excluded[i] != 0) difference(static_cast<Index>(i)) = 0.0;
  const PowerDensity densities(std::move(difference), motion.sample_rate_hz);
  double sum = 0.0, sum_of_v = 0.0;
  for (double f = 0.0; f < band.cutoff_hz; f += step_hz_) {
    density_of_difference_.push_back(densities.between(f, f + step_hz_));
    sum += density_of_difference_.back(), sum_of_v += density_of_v(f + 0.5 * step_hz_);
  }
  constexpr double one_sensor = 0.5;  // two differ by the noise of both: less than half of one's are the same twice
  if (sum < one_sensor * sum_of_v || sum_of_v == 0.0) density_of_difference_.clear();
  density_of_a_ = density_beyond_harmonics(motion, a->values, period_s);
}

VectorXd JointVelocity::of(const Motion& motion) const {
  const ExtendedSpectrum v = spectrum_of(motion, "v");
  if (density_of_difference_.empty()) return combined(v, nullptr);
  const ExtendedSpectrum a = spectrum_of(motion, "a");
  return combined(v, &a);
}

VectorXd JointVelocity::combined(const ExtendedSpectrum& v, const ExtendedSpectrum* a) const {
  if (a == nullptr || density_of_difference_.empty()) return v.filtered([&](double f) { return band_.gain(f); });
  return sum_of(
      v, *a, [&](double f) { return band_.gain(f) * (1.0 - weight_of_a(f)); },
      [&](double f) { return band_.gain(f) * weight_of_a(f); });
}

double JointVelocity::noise_m_per_s() const {
  constexpr int steps = 256;
  const double step_hz = band_.cutoff_hz / steps;
  double power = 0.0;
  for (int k = 0; k < steps; ++k) {
    const double f = (k + 0.5) * step_hz;
    power += (1.0 - weight_of_a(f)) * density_of_v(f) * std::pow(band_.gain(f), 2) * step_hz;
  }
  return std::sqrt(power);
}

double JointVelocity::density_of_v(double frequency_hz) const {
  return of_its_own_ ? density_of_v_ : omega(frequency_hz) * omega(frequency_hz) * density_of_x_;
}

double JointVelocity::weight_of_a(double frequency_hz) const {
  const auto step = static_cast<std::size_t>(frequency_hz / step_hz_);
  if (step >= density_of_difference_.size() || frequency_hz == 0.0) return 0.0;
  const double of_v = density_of_v(frequency_hz), of_a = density_of_a_ / (omega(frequency_hz) * omega(frequency_hz));
  const double both = std::max(density_of_difference_[step], of_v + of_a);
  return both > 0.0 ? of_v / both : 0.0;
}

}  // namespace dsp
