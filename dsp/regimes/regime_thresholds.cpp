#include "dsp/regimes/regime_thresholds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dsp/order_statistics.hpp"

namespace dsp {
namespace {

using Eigen::Index;

/// Velocity amplitudes of cycles. A cycle moves if it reaches a tenth of the record's.
struct CycleAmplitudes {
  double small = 0.0;   ///< that 97 of 100 cycles in motion exceed
  double shown = 0.0;   ///< that noise is held against: the same; where most cycles rest, the median of the others
  double median = 0.0;  ///< of all
};

CycleAmplitudes velocity_amplitudes(const RegimeSigns& signs) {
  const Index period = signs.samples_in(signs.period_s);
  std::vector<double> peaks;
  for (Index first = 0; first + period <= signs.num_samples(); first += period)
    if (std::none_of(signs.excluded.begin() + first, signs.excluded.begin() + first + period,
                     [](unsigned char one) { return one != 0; }))
      peaks.push_back(signs.velocity_m_per_s.segment(first, period).cwiseAbs().maxCoeff());
  if (const double all = signs.velocity_m_per_s.cwiseAbs().maxCoeff(); peaks.empty()) return {all, all, all};
  std::sort(peaks.begin(), peaks.end());
  const auto above = [&](double bar) { return std::lower_bound(peaks.begin(), peaks.end(), bar); };
  const double median = peaks[peaks.size() / 2];
  const auto part = [&](auto from, std::ptrdiff_t percent) { return from[(peaks.end() - from) * percent / 100]; };
  constexpr double clear_of_noise = 5.0;
  const auto clear = above(clear_of_noise * signs.speed_noise_m_per_s);
  if (clear != peaks.end() && 2 * (peaks.end() - clear) < peaks.end() - peaks.begin())
    return {part(above(0.1 * part(clear, 90)), 3), part(clear, 50), median};
  const double small = part(above(0.1 * part(peaks.begin(), 90)), 3);
  return {small, small, median};
}

}  // namespace

void choose_stick(const RegimeSigns& signs, Segmentation& result) {
  SegmentOptions& options = result.options;
  if (options.stick_speed_m_per_s > 0.0) return;
  constexpr double fraction = 0.04, noise_stds = 3.0, largest_fraction = 0.3;
  const CycleAmplitudes amplitudes = velocity_amplitudes(signs);
  const double by_motion = fraction * amplitudes.small, by_base = 0.02 * signs.base_speed_m_per_s,
               by_noise = noise_stds * signs.speed_noise_m_per_s;
  // What does not leave its base is stuck to it.
  const bool rests = signs.base_moves() && amplitudes.median < std::max(by_noise, by_base);
  if (!rests && by_noise > largest_fraction * amplitudes.shown) {
    result.remarks.push_back(
        fmt::format("stops are not looked for: v has {:.2g} m/s of noise beside amplitudes of {:.2g}",
                    signs.speed_noise_m_per_s, amplitudes.shown));
    return;
  }
  const double floor = rests ? std::max(by_noise, by_base) : by_noise;
  options.stick_speed_m_per_s = std::max(by_motion, floor);
  result.remarks.push_back(fmt::format(
      "a stop is what the speed below {:.2g} m/s shows to last longer than passing through zero does: {}",
      options.stick_speed_m_per_s,
      floor <= by_motion ? fmt::format("{:g} % of the smaller velocity amplitudes", 100.0 * fraction)
      : floor > by_noise ? std::string("2 % of the base's velocity, since the payload hardly moves against it")
                         : fmt::format("{:g} times the noise of v", noise_stds)));
  if (!signs.mount.is_rigid())
    result.remarks.push_back(fmt::format(
        "the sensors' mount rings at {:.3g} Hz (damping {:.2g}): its ringing is subtracted before stops are looked for",
        signs.mount.frequency_hz, signs.mount.damping));
  if (!signs.reversals.empty())
    result.remarks.push_back(
        fmt::format("a reversal is a stop where the acceleration below {:.3g} Hz shows a halt", signs.halts_below_hz));
}

}  // namespace dsp
