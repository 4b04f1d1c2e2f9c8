#pragma once
#include <limits>
#include <numbers>

namespace dsp {

inline constexpr double pi = std::numbers::pi, two_pi = 2.0 * pi, degrees_a_radian = 180.0 / pi;
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double gravity = 9.80665;  ///< m/s^2, standard
inline constexpr double day_s = 86400.0;

}  // namespace dsp
