#include "ident/validate/energy_terms.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/sensors/motion.hpp"
#include "ident/equation/interval_95.hpp"
#include "ident/library/expression.hpp"

namespace ident {
namespace {

/// A motion that has every sign of position and speed, at this speed.
dsp::Motion all_signs(double speed) {
  const Eigen::Vector4d x(1.0, 1.0, -1.0, -1.0), v = speed * Eigen::Vector4d(1.0, -1.0, 1.0, -1.0);
  dsp::Motion motion;
  motion.sample_rate_hz = 1.0;
  for (const auto& [name, values] : {std::pair("x", x), std::pair("y", x), std::pair("v", v), std::pair("dy", v)})
    motion.signals.push_back({name, "", values});
  return motion;
}

/// Its power at every sign; empty where it is of other signals.
Eigen::ArrayXd powers(const std::string& term, double speed) {
  const Expression expression(term);
  const dsp::Motion motion = all_signs(speed);
  const auto& signals = expression.signals();
  if (std::any_of(signals.begin(), signals.end(), [&](const auto& one) { return motion.find(one) == nullptr; }))
    return {};
  return expression.evaluate(motion).array() * motion.at("v").array();
}

}  // namespace

bool is_damping(const std::string& term) {
  const Eigen::ArrayXd power = powers(term, 1.0);
  return power.size() > 0 && (power > 0.0).all();
}

bool is_dry_friction(const std::string& term) {
  constexpr double slow = 1e-6;
  return is_damping(term) && (powers(term, slow) > 0.5 * slow * powers(term, 1.0)).all();
}

EnergyTerms energy_terms(const Model& model) {
  EnergyTerms result;
  if (model.target != "a" && model.target != "ddy") return result;
  for (const ModelTerm& term : model.terms) {
    if (!is_damping(term.name) || !(std::abs(term.mean) > interval_95 * term.std)) continue;
    (term.mean > 0.0 ? result.feed : result.take).push_back(label(term));
    result.friction_feeds = result.friction_feeds || (term.mean > 0.0 && is_dry_friction(term.name));
  }
  return result;
}

bool LossPerCycle::falls() const {
  constexpr double beyond_chance = 3.0;
  return mean > beyond_chance * std;
}

std::optional<LossPerCycle> loss_per_cycle(const Crests& crests, double least) {
  constexpr std::size_t fewest = 4;  // two degrees of freedom beside the line
  double weights = 0.0, sum = 0.0;
  for (const std::vector<double>& stretch : crests) {
    std::vector<double> logs;
    for (const double crest : stretch)
      if (crest >= least && crest > 0.0) logs.push_back(std::log(crest));
    logs.erase(logs.begin(), logs.begin() + std::ssize(logs) / 2);
    if (logs.size() < fewest) continue;
    const auto n = static_cast<double>(logs.size());
    const Eigen::Map<const Eigen::ArrayXd> y(logs.data(), std::ssize(logs));
    const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(y.size(), -0.5 * (n - 1.0), 0.5 * (n - 1.0));
    const double spread = t.square().sum(), slope = (t * y).sum() / spread;
    const double variance = (y - y.mean() - slope * t).square().sum() / (n - 2.0) / spread;
    const double weight = 1.0 / std::max(variance, 1e-24);
    weights += weight, sum -= weight * slope;
  }
  if (weights == 0.0) return std::nullopt;
  return LossPerCycle{-std::expm1(-sum / weights), std::sqrt(1.0 / weights) * std::exp(-sum / weights)};
}

}  // namespace ident
