#pragma once
#include <algorithm>
#include <cmath>

namespace sim {

/// Where a function is zero between two points at which its signs differ.
struct Bracket {
  double low = 0.0, high = 0.0;        ///< of which high is the one beyond the zero
  double at_low = 0.0, at_high = 0.0;  ///< the function there; at_high may be zero
};

/// Narrows a bracket to `width`, or to a point whose value is zero, which is then `high`: false position in its
/// Illinois variant, bisection wherever three of its steps did not halve the bracket.
template <class Function>
[[nodiscard]] Bracket zero_of(const Function& g, Bracket b, double width) {
  double weight_low = 1.0, weight_high = 1.0;  // of an end that stayed twice, halved each time
  bool low_stayed = false, high_stayed = false;
  double length = b.high - b.low;
  for (int i = 1; i <= 300 && b.high - b.low > width && b.at_high != 0.0; ++i) {
    const double low = weight_low * b.at_low, high = weight_high * b.at_high;
    double middle = b.high - high * (b.high - b.low) / (high - low);
    if (i % 4 == 0) {
      const bool slow = b.high - b.low > 0.5 * length;
      if (slow) middle = 0.5 * (b.low + b.high);
      length = (slow ? 0.5 : 1.0) * (b.high - b.low);
    }
    // Never closer to an end than half the width, so that both ends come in.
    middle = std::clamp(middle, b.low + 0.5 * width, b.high - 0.5 * width);
    const double value = g(middle);
    const bool before = b.at_low > 0.0 ? value > 0.0 : value < 0.0;
    if (before) {
      b.low = middle, b.at_low = value, weight_low = 1.0;
      weight_high *= high_stayed ? 0.5 : 1.0;
    } else {
      b.high = middle, b.at_high = value, weight_high = 1.0;
      weight_low *= low_stayed ? 0.5 : 1.0;
    }
    high_stayed = before;
    low_stayed = !before;
  }
  return b;
}

}  // namespace sim
