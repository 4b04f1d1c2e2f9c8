#include "dsp/prepare/recorded_derivatives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "dsp/filter/spectral.hpp"
#include "dsp/prepare/motion_band.hpp"
#include "dsp/sensors/motion.hpp"
#include "dsp/sensors/sensor_consistency.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Mean square of the derivative of white noise of this one-sided density, up to a cut-off.
double derived_noise(double density, double cutoff_hz) {
  return density * std::pow(2.0 * std::numbers::pi, 2) * std::pow(cutoff_hz, 3) / 3.0;
}

struct Difference {
  double mean_square = 0.0, of_velocity = 0.0, gain = 0.0;  ///< gain: recorded over derived, with its sign
};

/// 1 where samples may be compared: away from the ends, which lean on prediction, and from what is bad.
Eigen::ArrayXd comparable(const Recording& recording, double cutoff_hz) {
  constexpr double lengths = 4.0;  // of the band's response, either side
  const Index n = recording.samples.rows(), edge = n / 10;
  Motion marked{.sample_rate_hz = recording.sample_rate_hz};
  marked.excluded.assign(static_cast<std::size_t>(n), 0);
  for (const Interval& bad : recording.bad) mark(marked, bad, lengths / cutoff_hz);
  Eigen::ArrayXd use(n);
  for (Index i = 0; i < n; ++i)
    use(i) = i >= edge && i < n - edge && marked.excluded[static_cast<std::size_t>(i)] == 0 ? 1.0 : 0.0;
  return use;
}

Difference difference(const Recording& recording, Index displacement, Index velocity, double cutoff_hz) {
  const SpectralBand band{0.78125 * cutoff_hz, cutoff_hz};
  const Eigen::ArrayXd use = comparable(recording, cutoff_hz);
  const double count = use.sum();
  if (!(count > 0.0)) return {};
  const auto centred = [&](Index column, int order) -> Eigen::ArrayXd {
    const VectorXd values =
        ExtendedSpectrum(recording.samples.col(column), recording.sample_rate_hz).derivative(order, band);
    return use * (values.array() - (use * values.array()).sum() / count);
  };
  const Eigen::ArrayXd derived = centred(displacement, 1), recorded = centred(velocity, 0);
  const double of_velocity = derived.square().sum() / count;
  if (!(of_velocity > 0.0)) return {};
  const double gain = (recorded * derived).sum() / count / of_velocity;
  // A wrong sensitivity is no wrong signal: gains are the checks' matter.
  return {(recorded - gain * derived).square().sum() / count, of_velocity, gain};
}

}  // namespace

std::vector<Check> drop_unlike_derivatives(Recording& recording, const RawSpectrum& spectrum, double cutoff_hz) {
  constexpr double noises = 3.0;
  constexpr double linear = 3e-3;  // few sensors are linear to less
  std::vector<Check> checks;
  const Eigen::MatrixXd power = spectrum.power();
  if (power.rows() == 0 || recording.samples.rows() < 64) return checks;
  for (const Body body : {Body::relative, Body::base, Body::payload}) {
    const Index d = recording.find(motion_signal(body, 0).role), v = recording.find(motion_signal(body, 1).role);
    if (d < 0 || v < 0) continue;
    const MotionBand band = motion_band("", 0, power.col(d), spectrum.bin_hz());
    if (band.noise == 0.0) continue;
    const double used_hz = std::min(cutoff_hz, 0.45 * recording.sample_rate_hz);
    const Difference found = difference(recording, d, v, used_hz);
    const double expected = derived_noise(band.noise / band.bin_hz, used_hz);
    if (!(found.mean_square > noises * expected + std::pow(linear, 2) * found.of_velocity)) continue;
    if (!(std::abs(found.gain - 1.0) <= largest_gain_error)) continue;  // another unit or sign: named by the checks
    Channel& channel = recording.channels[static_cast<std::size_t>(v)];
    const std::string& displacement = recording.channels[static_cast<std::size_t>(d)].name;
    checks.push_back({.name = "sensor.derivative",
                      .channel = channel.name,
                      .status = CheckStatus::warning,
                      .value = std::sqrt(found.mean_square / found.of_velocity),
                      .limit = std::sqrt(noises * expected / found.of_velocity),
                      .message = fmt::format("differs from the derivative of {} by {:.2g} % up to {:.3g} Hz, where the "
                                             "noise of {} explains {:.2g} %; the derivative is used in its place",
                                             displacement, 100.0 * std::sqrt(found.mean_square / found.of_velocity),
                                             used_hz, displacement, 100.0 * std::sqrt(expected / found.of_velocity))});
    channel.role = Role::other;
  }
  return checks;
}

}  // namespace dsp
