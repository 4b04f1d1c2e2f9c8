#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

namespace sim {

/// What the payload truly did from from_s to to_s: "stick", "low" or "high" amplitude.
struct RegimeSpan {
  std::string label;
  double from_s = 0.0, to_s = 0.0;
};

struct RegimeOptions {
  double stick_margin_s = 1.0;                         ///< either side of every true stick
  double high_enter_m = 17e-3, high_leave_m = 9.5e-3;  ///< of the envelope: between the branches of stepped_sine_down
  double envelope_s = 2.0, mean_s = 6.0;  ///< half of max - min over the one, of x less its mean over the other
  double min_duration_s = 10.0;           ///< shorter runs join the run before them; between sticks they are stick
};

/// Exact x and modes (QzsMode) at a rate, as stretches in order without gaps.
[[nodiscard]] std::vector<RegimeSpan> true_regimes(const Eigen::Ref<const Eigen::VectorXd>& x,
                                                   const std::vector<int>& modes, double sample_rate_hz,
                                                   const RegimeOptions& options = {});

}  // namespace sim
