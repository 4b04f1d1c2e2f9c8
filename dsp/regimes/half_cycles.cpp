#include "dsp/regimes/half_cycles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dsp/filter/power_density.hpp"
#include "dsp/regimes/harmonics.hpp"

namespace dsp {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Free of offset, drift and noise beyond the harmonics.
VectorXd harmonics_of(const VectorXd& signal, double rate_hz, double period_s) {
  if (signal.size() < 8 || !(signal.maxCoeff() > signal.minCoeff())) return {};
  const SpectralBand band = harmonics_band(period_s);
  const SpectralBand drift{0.5 * drift_below / period_s, drift_below / period_s};
  ExtendedSpectrum spectrum(signal, rate_hz);
  spectrum.multiply([&](double f) { return band.gain(f) - drift.gain(f); });
  return std::move(spectrum).signal();
}

/// Variance by noise of this density of the phase of a sine fitted to `seconds`; what exceeds the noise within the band
/// is the sine.
double phase_variance(double mean_square, double density, double seconds, double band_hz) {
  const double amplitude_square = 2.0 * (mean_square - density * band_hz);
  if (amplitude_square <= 0.0) return std::numeric_limits<double>::infinity();
  return density / (seconds * amplitude_square);
}

}  // namespace

double density_beyond_harmonics(const Motion& motion, const VectorXd& signal, double period_s) {
  const double rate_hz = motion.sample_rate_hz, from_hz = 2.0 * num_harmonics / period_s,
               to_hz = 3.0 * num_harmonics / period_s;
  std::vector<unsigned char> excluded = motion.excluded;
  excluded.resize(static_cast<std::size_t>(signal.size()), 0);
  double sum = 0.0, seconds = 0.0;
  for (auto begin = excluded.begin(); begin != excluded.end();) {
    const auto end = std::find_if(begin, excluded.end(), [&](auto one) { return (one != 0) != (*begin != 0); });
    const Index count = end - begin;
    const double lasts_s = static_cast<double>(count) / rate_hz;
    if (*begin == 0 && lasts_s >= period_s) {
      const auto part = signal.segment(begin - excluded.begin(), count);
      const PowerDensity densities(Eigen::Ref<const VectorXd>(part), rate_hz);
      sum += lasts_s * densities.between(from_hz, to_hz), seconds += lasts_s;
    }
    begin = end;
  }
  return seconds > 0.0 ? sum / seconds : PowerDensity(signal, rate_hz).between(from_hz, to_hz);
}

namespace {

std::vector<HalfCycle> half_cycles_between_zeros(const Motion& motion, const VectorXd& drive, double drive_density,
                                                 double period_s) {
  const double rate_hz = motion.sample_rate_hz;
  const VectorXd& x = motion.at("x");
  const double x_density = density_beyond_harmonics(motion, x, period_s);
  std::vector<HalfCycle> all;
  std::vector<Index> zeros;
  for (Index i = 1; i < drive.size(); ++i) {
    if ((drive[i] > 0.0) == (drive[i - 1] > 0.0)) continue;
    zeros.push_back(i);
    if (zeros.size() < 3) continue;
    HalfCycle half{.first = zeros[zeros.size() - 3], .middle = zeros[zeros.size() - 2], .last = i};
    const Index count = i - half.first;
    const auto swing = x.segment(half.first, count), driven = drive.segment(half.first, count);
    const double mean = swing.mean(), samples = static_cast<double>(count), seconds = samples / rate_hz;
    const double power = (swing.array() - mean).square().mean(), drive_power = driven.squaredNorm() / samples;
    half.correlation = swing.dot(driven) - mean * driven.sum();
    half.cosine = power > 0.0 ? half.correlation / (samples * std::sqrt(power * drive_power)) : 0.0;
    half.amplitude = std::sqrt(2.0 * power);
    // Noise turns a sine as much as, by its fraction, it makes it larger.
    half.drive_level = 0.5 * std::log(drive_power);
    half.drive_variance = phase_variance(drive_power, drive_density, seconds, num_harmonics / period_s);
    half.phase_variance = phase_variance(power, x_density, seconds, 0.5 * rate_hz) + half.drive_variance;
    all.push_back(half);
  }
  return all;
}

}  // namespace

std::vector<HalfCycle> half_cycles(const Motion& motion, double period_s) {
  for (const char* name : {"r", "ddr", "f"}) {
    const Signal* signal = motion.find(name);
    if (signal == nullptr) continue;
    VectorXd drive = harmonics_of(signal->values, motion.sample_rate_hz, period_s);
    if (signal->name == "ddr") drive = -drive;  // opposite to the displacement
    const double density = density_beyond_harmonics(motion, signal->values, period_s);
    return half_cycles_between_zeros(motion, drive, density, period_s);
  }
  return {};
}

std::vector<HalfCycle> own_half_cycles(const Motion& motion, double period_s) {
  return half_cycles_between_zeros(motion, harmonics_of(motion.at("x"), motion.sample_rate_hz, period_s), 0.0,
                                   period_s);
}

}  // namespace dsp
