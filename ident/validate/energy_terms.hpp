#pragma once
#include <optional>
#include <string>
#include <vector>

#include "ident/equation/model.hpp"
#include "ident/validate/crests.hpp"

// What takes energy from a motion, and what feeds it.

namespace ident {

/// Whether a term is a friction or a damping: an odd function of a speed (v, or dy beside ground that friction acts
/// against), whatever x is: v, x^2*v, abs(v)*v, sgn(v).
[[nodiscard]] bool is_damping(const std::string& term);

/// A friction, which jumps where the speed passes zero.
[[nodiscard]] bool is_dry_friction(const std::string& term);

/// The frictions and dampings of an equation for an acceleration by what they do. One whose 95 % interval includes zero
/// does neither; of a term with a coefficient for each recording the names are those of label().
struct EnergyTerms {
  std::vector<std::string> take, feed;
  bool friction_feeds = false;  ///< a dry friction is among those that feed
};
[[nodiscard]] EnergyTerms energy_terms(const Model& model);

/// By what fraction a free motion's crests fall a cycle, by a straight line through their logarithms.
struct LossPerCycle {
  double mean = 0.0, std = 0.0;
  [[nodiscard]] bool falls() const;  ///< by more than three standard deviations: chance does so once in 700
};
/// Of the later half of crests that are `least` or more, since a self-excited motion that begins above its limit cycle
/// falls at first; the mean of stretches, weighted. Nothing of fewer than four in every one.
[[nodiscard]] std::optional<LossPerCycle> loss_per_cycle(const Crests& crests, double least);

}  // namespace ident
