#include "dsp/regimes/regime_thresholds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dsp/regimes/harmonics.hpp"

namespace dsp {
namespace {

/// Of the kept samples those that are part of no rest: slower than this for longer than a sine takes from zero to its
/// crest. The amplitude of a sine of their mean speed, for which
/// large swings count for less than in its rms, and the fraction they are.
struct Swings {
  double amplitude = 0.0, fraction = 0.0;
};
Swings swings_between_rests(double speed_m_per_s, const RegimeSigns& signs) {
  using Eigen::Index;
  double sum = 0.0, swinging = 0.0, kept = 0.0;
  const auto is_slow = [&](Index i) { return std::abs(signs.velocity_m_per_s(i)) < speed_m_per_s; };
  for (Index first = 0, end = 0; first < signs.num_samples(); first = end) {
    end = first + 1;
    while (end < signs.num_samples() && is_slow(end) == is_slow(first)) ++end;
    for (Index i = first; i < end; ++i) {
      if (signs.excluded[static_cast<std::size_t>(i)] != 0) continue;
      kept += 1.0;
      if (is_slow(first) && static_cast<double>(end - first) >= signs.quarter_period()) continue;
      sum += std::abs(signs.velocity_m_per_s(i)), swinging += 1.0;
    }
  }
  return {swinging > 0.0 ? std::numbers::pi / 2.0 * sum / swinging : 0.0, kept > 0.0 ? swinging / kept : 0.0};
}

}  // namespace

void choose_stick(const RegimeSigns& signs, Segmentation& result) {
  SegmentOptions& options = result.options;
  if (options.stick_speed_m_per_s > 0.0) return;
  const double by_noise = noise_stds * signs.speed_noise_m_per_s;
  const double all = swings_between_rests(0.0, signs).amplitude,
               by_motion = sensors_agree * std::max(all, signs.base_speed_m_per_s),
               slow = std::max(by_motion, by_noise);
  // Where it rests for most of the time, the amplitude is that of its swings.
  constexpr double most = 0.5;
  const Swings swings = swings_between_rests(2.0 * slow, signs);
  const double own = swings.amplitude > 0.0 && swings.fraction < most ? swings.amplitude : all;
  const bool rests_on_base = signs.base_moves() && all < slow;
  // The speed is timed up to twice the threshold: where a sine is straight, to half of its amplitude. Of three times
  // the noise, to a quarter: a line no longer than that is mistaken for a halt in one passage of some dozens.
  const double straight = by_noise < by_motion ? 0.5 : 0.25;
  if (!rests_on_base && 2.0 * slow > straight * own) {
    result.remarks.push_back(
        fmt::format("stops are not looked for: {} beside amplitudes of {:.2g} m/s",
                    by_noise < by_motion
                        ? fmt::format("{:g} % of the base's speed, {:.2g} m/s, is much", 100.0 * sensors_agree, slow)
                        : fmt::format("v has {:.2g} m/s of noise", signs.speed_noise_m_per_s),
                    own));
    return;
  }
  options.stick_speed_m_per_s = slow;
  result.remarks.push_back(fmt::format(
      "a stop is what the speed below {:.2g} m/s shows to last longer than passing through zero does: {}", slow,
      by_noise < by_motion ? fmt::format("{:g} % of {}", 100.0 * sensors_agree,
                                         all < signs.base_speed_m_per_s ? "the base's speed" : "the speed")
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
