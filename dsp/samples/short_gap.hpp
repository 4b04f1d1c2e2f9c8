#pragma once

namespace dsp {

/// Whether a gap, so many steps from the value before to that behind, is bridged by a parabola through one more value
/// before: over one lost sample its error is of the third order in the step and a line's of the second; over long gaps
/// it would carry the noise of its two near values too far.
[[nodiscard]] constexpr bool is_curved_gap(double steps) {
  constexpr double least = 1.5, most = 4.0;
  return steps > least && steps <= most;
}

/// At `at`, the parabola that is zero at 0 and at `other` and 1 at `own`.
[[nodiscard]] constexpr double parabola(double own, double other, double at) {
  return at * (at - other) / (own * (own - other));
}

}  // namespace dsp
