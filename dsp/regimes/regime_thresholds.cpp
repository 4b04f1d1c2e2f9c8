#include "dsp/regimes/regime_thresholds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "dsp/regimes/harmonics.hpp"

namespace dsp {
void choose_stick(const RegimeSigns& signs, Segmentation& result) {
  SegmentOptions& options = result.options;
  if (options.stick_speed_m_per_s > 0.0) return;
  // Amplitude of a sine of this mean speed: large swings count for less than in its rms.
  const double own = std::numbers::pi / 2.0 * signs.velocity_m_per_s.cwiseAbs().mean(),
               by_motion = sensors_agree * std::max(own, signs.base_speed_m_per_s),
               by_noise = noise_stds * signs.speed_noise_m_per_s, slow = std::max(by_motion, by_noise);
  const bool rests_on_base = signs.base_moves() && own < slow;
  // The speed is timed up to twice the threshold: where a sine is straight, to half of its amplitude.
  constexpr double straight = 0.5;
  if (!rests_on_base && 2.0 * slow > straight * own) {
    result.remarks.push_back(
        fmt::format("stops are not looked for: v has {:.2g} m/s of noise beside amplitudes of {:.2g}",
                    signs.speed_noise_m_per_s, own));
    return;
  }
  options.stick_speed_m_per_s = slow;
  result.remarks.push_back(fmt::format(
      "a stop is what the speed below {:.2g} m/s shows to last longer than passing through zero does: {}", slow,
      by_noise < by_motion ? fmt::format("{:g} % of {}", 100.0 * sensors_agree,
                                         own < signs.base_speed_m_per_s ? "the base's speed" : "the speed")
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
