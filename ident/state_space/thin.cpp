#include "ident/state_space/thin.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "dsp/filter/power_density.hpp"
#include "dsp/filter/spectral.hpp"
#include "ident/state_space/start.hpp"

namespace ident::state_space {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double of_motion = 0.25, passed = 0.45, stopped = 0.55;  // of the lower rate
constexpr Index of_ends = 8;

/// Above it is no more than a part of the power of a signal that has no noise.
double end_of_power_hz(const VectorXd& signal, double rate_hz) {
  constexpr double negligible = 1e-10;
  constexpr int halvings = 12;
  const dsp::ExtendedSpectrum spectrum(signal, rate_hz);
  double below = 0.0, above = 0.5 * rate_hz;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (below + above);
    (spectrum.power_fraction_above(middle) > negligible ? below : above) = middle;
  }
  return above;
}

/// Above it the spectrum of a channel is its noise, by means over a twentieth of it.
double end_of_motion_hz(const VectorXd& signal, double rate_hz, double noise_std) {
  constexpr double above_noise = 2.0;  // means of 50 ordinates and more are known to a fifth
  constexpr Index windows = 20;
  const dsp::PowerDensity density(signal, rate_hz);
  const Index width = std::max<Index>(1, density.ordinates().size() / windows);
  const double floor = above_noise * noise_std * noise_std / (0.5 * rate_hz);
  for (Index first = density.ordinates().size() - width; first >= 0; --first)
    if (density.ordinates().segment(first, width).mean() > floor)
      return static_cast<double>(first + 1) * density.step_hz();  // its lower end is what it has more of
  return density.step_hz();
}

}  // namespace

Index thinning(const Problem& problem) {
  constexpr Index least = 1000;  // also of a record whose spectrum is asked
  const double rate_hz = problem.sample_rate_hz;
  if (std::any_of(problem.channels.begin(), problem.channels.end(), [](const Channel& one) { return one.rate; }))
    return 1;
  Index samples = 0;
  for (const Record& record : problem.records) {
    if (record.channels.array().isNaN().any()) return 1;
    samples += record.channels.rows();
  }
  const std::vector<double> floors = noise_floors(problem);
  double highest_hz = 0.0;
  for (const Record& record : problem.records) {
    if (record.channels.rows() < least) continue;
    for (Index j = 0; j < record.channels.cols(); ++j)
      highest_hz =
          std::max(highest_hz, end_of_motion_hz(record.channels.col(j), rate_hz, floors[static_cast<std::size_t>(j)]));
    for (Index i = 0; i < record.inputs.cols(); ++i)
      highest_hz = std::max(highest_hz, std::min(end_of_power_hz(record.inputs.col(i), rate_hz),
                                                 without_noise(record.inputs.col(i), rate_hz).to_hz));
  }
  if (highest_hz == 0.0) return 1;
  const double most = of_motion * rate_hz / highest_hz;
  return std::clamp<Index>(std::min(static_cast<Index>(most), samples / least), 1, samples);
}

Problem thinned(Problem problem, Index factor) {
  if (factor < 1) throw std::invalid_argument("thinned: a factor below 1");
  if (factor == 1) return problem;
  const double rate_hz = problem.sample_rate_hz / static_cast<double>(factor);
  const dsp::SpectralBand band{passed * rate_hz, stopped * rate_hz};
  const auto thin = [&](Eigen::MatrixXd& signals) {
    const Index size = (signals.rows() - 1) / factor + 1 - 2 * of_ends;
    Eigen::MatrixXd fewer(size, signals.cols());
    for (Index j = 0; j < signals.cols(); ++j) {
      const VectorXd low = dsp::ExtendedSpectrum(signals.col(j), problem.sample_rate_hz).filtered([&](double f) {
        return band.gain(f);
      });
      for (Index k = 0; k < size; ++k) fewer(k, j) = low((k + of_ends) * factor);
    }
    signals = std::move(fewer);
  };
  constexpr Index fewest = 16;  // of a piece: less says nothing but where it begins
  std::erase_if(problem.records,
                [&](const Record& record) { return (record.channels.rows() - 1) / factor + 1 < fewest + 2 * of_ends; });
  for (Record& record : problem.records) {
    thin(record.channels), thin(record.inputs);
    record.begin_s += static_cast<double>(of_ends) / rate_hz;
  }
  for (double& std : problem.input_noise_std) std /= std::sqrt(static_cast<double>(factor));
  problem.sample_rate_hz = rate_hz;
  problem.steps = static_cast<int>((factor + 1) / 2);  // the motion is smooth, its equation may be stiffer
  return problem;
}

}  // namespace ident::state_space
