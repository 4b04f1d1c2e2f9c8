#include "apps/regimes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace apps {

using Eigen::Index;

bool belongs(dsp::Regime regime, const std::string& wanted) {
  if (wanted.empty()) return true;
  if (wanted == "mixed") return regime == dsp::Regime::low || regime == dsp::Regime::high;
  return to_string(regime) == wanted;
}

std::vector<dsp::Regime> regimes_at(const dsp::Segmentation& segmentation, const dsp::Prepared& prepared) {
  std::vector<dsp::Regime> regimes(static_cast<std::size_t>(prepared.signals.num_samples()), dsp::Regime::excluded);
  const double ratio = prepared.bus.sample_rate_hz / prepared.signals.sample_rate_hz;
  auto segment = segmentation.segments.begin();
  for (std::size_t i = 0; i < regimes.size(); ++i) {
    const auto on_bus = static_cast<Index>(std::llround(static_cast<double>(i) * ratio));
    while (segment != segmentation.segments.end() && segment->last <= on_bus) ++segment;
    if (segment != segmentation.segments.end()) regimes[i] = segment->regime;
  }
  return regimes;
}

PowerCheck power_check(const dsp::Prepared& prepared, const std::vector<dsp::Regime>& regimes) {
  const auto balance = [&](const Eigen::VectorXd& v, const Eigen::VectorXd& a, dsp::Regime wanted) {
    std::vector<unsigned char> use(regimes.size());
    for (std::size_t i = 0; i < use.size(); ++i) use[i] = regimes[i] == wanted ? 1 : 0;
    return dsp::power_balance(v, a, use);
  };
  const Eigen::VectorXd &v = prepared.signals.at("v"), &a = prepared.signals.at("a");
  return {balance(prepared.raw_v, prepared.raw_a, dsp::Regime::low),
          balance(prepared.raw_v, prepared.raw_a, dsp::Regime::high), balance(v, a, dsp::Regime::low),
          balance(v, a, dsp::Regime::high)};
}

double corrected_balance(const PowerCheck& power, const std::string& regime) {
  if (regime == "low") return power.corrected_low;
  if (regime == "high") return power.corrected_high;
  return std::fmax(std::abs(power.corrected_low), std::abs(power.corrected_high));
}

dsp::Check judged(const PowerCheck& power, const std::vector<dsp::SensorRelation>& relations) {
  constexpr double limit = 0.02;  // velocity and acceleration out of phase by about a degree
  const double raw = std::fmax(std::abs(power.raw_low), std::abs(power.raw_high));
  const double corrected = std::fmax(std::abs(power.corrected_low), std::abs(power.corrected_high));
  if (!std::isfinite(raw))
    return {"power.balance",
            "",
            dsp::CheckStatus::note,
            raw,
            limit,
            "power balance not computed: no regime of motion has rows with velocity and acceleration"};
  const bool agree = std::all_of(relations.begin(), relations.end(), dsp::can_be_corrected);
  return {"power.balance",
          "",
          raw > limit ? dsp::CheckStatus::warning : dsp::CheckStatus::ok,
          raw,
          limit,
          fmt::format("velocity and acceleration {}: power balance {:.2g} as measured, {}",
                      raw > limit ? "are out of step" : "are in step", raw,
                      agree ? fmt::format("{:.2g} after the sensors were brought to agree", corrected)
                            : "and the sensors could not be brought to agree")};
}

}  // namespace apps
