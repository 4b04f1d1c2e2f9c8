#include "dsp/sensors/power_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dsp {

PowerCheck power_check(const Prepared& prepared, const std::vector<Regime>& regimes) {
  const auto balance = [&](const Eigen::VectorXd& v, const Eigen::VectorXd& a, Regime wanted) {
    std::vector<unsigned char> use(regimes.size());
    for (std::size_t i = 0; i < use.size(); ++i) use[i] = regimes[i] == wanted ? 1 : 0;
    return power_balance(v, a, use);
  };
  const Eigen::VectorXd &v = prepared.signals.at("v"), &a = prepared.signals.at("a");
  return {balance(prepared.raw_v, prepared.raw_a, Regime::low), balance(prepared.raw_v, prepared.raw_a, Regime::high),
          balance(v, a, Regime::low), balance(v, a, Regime::high)};
}

Check check_of(const PowerCheck& power, const std::vector<SensorRelation>& relations) {
  constexpr double limit = 0.02;  // velocity and acceleration out of phase by about a degree
  const double raw = std::fmax(std::abs(power.raw_low), std::abs(power.raw_high));
  const double corrected = std::fmax(std::abs(power.corrected_low), std::abs(power.corrected_high));
  if (!std::isfinite(raw))
    return {"power.balance",
            "",
            CheckStatus::note,
            raw,
            limit,
            "power balance not computed: no regime of motion has rows with velocity and acceleration"};
  const bool agree = std::all_of(relations.begin(), relations.end(), can_be_corrected);
  return {"power.balance",
          "",
          raw > limit ? CheckStatus::warning : CheckStatus::ok,
          raw,
          limit,
          fmt::format("velocity and acceleration {}: power balance {:.2g} as measured, {}",
                      raw > limit ? "are out of step" : "are in step", raw,
                      agree ? fmt::format("{:.2g} after the sensors were brought to agree", corrected)
                            : "and the sensors could not be brought to agree")};
}

}  // namespace dsp
