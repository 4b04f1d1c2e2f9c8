#include "dsp/prepare/power_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/values/constants.hpp"

namespace dsp {

using Eigen::Index;
using Eigen::VectorXd;

double power_balance(const Eigen::Ref<const VectorXd>& velocity, const Eigen::Ref<const VectorXd>& acceleration,
                     const std::vector<unsigned char>& use) {
  double va = 0.0, vv = 0.0, aa = 0.0, v_sum = 0.0, a_sum = 0.0, count = 0.0;
  for (Index i = 0; i < velocity.size(); ++i) {
    if (use[static_cast<std::size_t>(i)] == 0) continue;
    v_sum += velocity(i), a_sum += acceleration(i), count += 1.0;
  }
  for (Index i = 0; i < velocity.size(); ++i) {
    if (use[static_cast<std::size_t>(i)] == 0) continue;
    const double v = velocity(i) - v_sum / count, a = acceleration(i) - a_sum / count;
    va += v * a, vv += v * v, aa += a * a;
  }
  return vv > 0.0 && aa > 0.0 ? va / std::sqrt(vv * aa) : std::numeric_limits<double>::quiet_NaN();
}

PowerCheck power_check(const Prepared& prepared, const std::vector<Regime>& regimes) {
  const VectorXd &v = prepared.signals.at("v"), &a = prepared.signals.at("a");
  PowerCheck power;
  for (const RegimeInfo& known : regime_table()) {
    if (!known.moving) continue;
    std::vector<unsigned char> use(regimes.size());
    for (std::size_t i = 0; i < use.size(); ++i) use[i] = regimes[i] == known.regime ? 1 : 0;
    power.push_back({known.regime, power_balance(prepared.raw_v, prepared.raw_a, use), power_balance(v, a, use)});
  }
  return power;
}

RegimePower balance_in(const PowerCheck& power, Regime regime) {
  const auto found = std::find_if(power.begin(), power.end(), [&](const auto& one) { return one.regime == regime; });
  return found == power.end() ? RegimePower{regime, nan, nan} : *found;
}

double largest_balance(const PowerCheck& power, const RegimeSet& regimes, double RegimePower::*which) {
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (const RegimePower& one : power)
    if (regimes.holds(one.regime)) largest = std::fmax(largest, std::abs(one.*which));
  return largest;
}

Check check_of(const PowerCheck& power, const std::vector<SensorRelation>& relations) {
  constexpr double limit = 0.02;  // velocity and acceleration out of phase by about a degree
  const double raw = largest_balance(power, {}, &RegimePower::raw);
  const double corrected = largest_balance(power, {}, &RegimePower::corrected);
  if (!std::isfinite(raw))
    return {"power.balance",
            "",
            CheckStatus::note,
            raw,
            limit,
            "power balance not computed: no regime of motion has rows with velocity and acceleration"};
  const bool settled = corrected <= limit;  // nothing is left to be done
  const bool agree = std::all_of(relations.begin(), relations.end(), can_be_corrected);
  return {"power.balance",
          "",
          raw <= limit ? CheckStatus::ok
          : settled    ? CheckStatus::note
                       : CheckStatus::warning,
          raw,
          limit,
          fmt::format("velocity and acceleration {}: power balance {:.2g} as measured, {}",
                      raw > limit ? "are out of step" : "are in step", raw,
                      agree ? fmt::format("{:.2g} after the sensors were corrected", corrected)
                            : "and the sensors could not be corrected")};
}

}  // namespace dsp
