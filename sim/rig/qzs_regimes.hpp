#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim/rig/base_motion.hpp"

namespace sim {

/// What the payload truly did from from_s to to_s: "stick", "low" or "high" amplitude.
struct RegimeInterval {
  std::string label;
  double from_s = 0.0, to_s = 0.0;
};

struct RegimeOptions {
  double stick_margin_s = 1.0;                    ///< either side of every true stick
  double high_enter_m = 0.0, high_leave_m = 0.0;  ///< required, of the envelope: true_levels
  double envelope_s = 2.0, mean_s = 6.0;          ///< half of max - min over the one, of x less its mean over the other
  double min_duration_s = 10.0;  ///< shorter runs join the run before them; between sticks they are stick
};

/// The two levels of a programme, from its dwells (a frequency of the moving base, its iterations together) in exact x
/// and modes, as below, from the programme's start on. The last third of a dwell counts, from where no hand is at the
/// payload: unless it sticks there, it is on the upper branch if x goes with the base's r (positive correlation), else
/// on the lower, with the amplitude of its last cycle, half of max - min.
/// high_enter_m: five eighths of the amplitude after a jump up, which is from a lower dwell to an upper one right
/// behind it (the geometric mean if there are several), where a jump is steepest; at least 1.1 times the largest
/// amplitude before one. high_leave_m: four fifths of the smallest upper amplitude, at most high_enter_m. Upper dwells
/// but no jump up: both levels are that. No upper dwell: both are infinite, no motion is high. Throws
/// std::invalid_argument unless there is one mode for each x, and a rate.
[[nodiscard]] RegimeOptions true_levels(const Eigen::Ref<const Eigen::VectorXd>& x, const std::vector<int>& modes,
                                        double sample_rate_hz, const Programme& programme);

/// Exact x and modes (QzsMode) at a rate, as intervals in order without gaps.
[[nodiscard]] std::vector<RegimeInterval> true_regimes(const Eigen::Ref<const Eigen::VectorXd>& x,
                                                       const std::vector<int>& modes, double sample_rate_hz,
                                                       const RegimeOptions& options);

}  // namespace sim
