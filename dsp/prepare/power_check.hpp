#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "dsp/prepare/prepared.hpp"
#include "dsp/regimes/regime.hpp"

namespace dsp {

/// rho = <v a> / (sigma_v sigma_a) over the samples of the mask: the power that stays. In steady motion it is zero but
/// for a boundary term 1 / (omega duration); a phase error of phi between v and a makes it sin(phi). NaN without
/// motion.
[[nodiscard]] double power_balance(const Eigen::Ref<const Eigen::VectorXd>& velocity,
                                   const Eigen::Ref<const Eigen::VectorXd>& acceleration,
                                   const std::vector<unsigned char>& use);

/// Power that seems to stay in one regime of motion, <v a> / (sigma_v sigma_a); NaN where it does not occur.
struct RegimePower {
  Regime regime;
  double raw = 0.0, corrected = 0.0;
};
using PowerCheck = std::vector<RegimePower>;  ///< one for each regime of motion

/// Before and after the sensors were corrected. `prepared` must hold raw_v and raw_a.
[[nodiscard]] PowerCheck power_check(const Prepared& prepared, const std::vector<Regime>& regimes);

/// Of one regime; NaN where it does not occur.
[[nodiscard]] RegimePower balance_in(const PowerCheck& power, Regime regime);
/// The largest magnitude in the regimes of a set, of what is raw or corrected; NaN where there is none.
[[nodiscard]] double largest_balance(const PowerCheck& power, const RegimeSet& regimes, double RegimePower::*which);

/// As a row of quality.json ("power.balance"): a warning where the raw signals are out of step.
[[nodiscard]] Check check_of(const PowerCheck& power, const std::vector<SensorRelation>& relations);

}  // namespace dsp
