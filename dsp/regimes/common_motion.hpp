#pragma once
#include <Eigen/Core>
#include <optional>

#include "dsp/regimes/regime.hpp"
#include "dsp/sensors/motion.hpp"

namespace dsp {

/// What two displacement sensors say of one another while their bodies move as one: y(t) = gain r(t + lead_s) + a
/// constant of each interval + one slope.
struct CommonMotion {
  double gain = 1.0, gain_std = 0.0;
  double lead_s = 0.0, lead_std_s = 0.0;  ///< positive: the base's sensor is late
  double duration_s = 0.0;                ///< of all intervals
};

/// From the intervals of stick in which |v| stays within ten times its median there for two seconds or more, half a
/// second at either end left out. Standard deviations come from the sums of a second each, whatever the colour of the
/// noise. `motion` needs r, dr, y and v. Nothing where there are less than ten such seconds, or the base does not move.
[[nodiscard]] std::optional<CommonMotion> find_common_motion(const Motion& motion, const Segmentation& segmentation);

/// Brings r, dr and ddr of a motion to the scale and the clock of y (by this gain and lead), and x, v and a with them.
void adopt(Motion& motion, double gain, double lead_s);

}  // namespace dsp
