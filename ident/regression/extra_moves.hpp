#pragma once
#include "ident/regression/fit.hpp"
#include "ident/regression/rvm_state.hpp"

// What the search of a fast RVM does beyond Algorithm 1 of [QZS23]. The algorithm climbs to the nearest of many ends,
// one term at a time; these take it on from there, or begin elsewhere.

namespace ident {

/// Re-estimates the lambda of every kept term at once (the fixed point of [Tip01] on the kept terms): far fewer moves
/// than one by one. The posterior and noise are left to the caller. False, and nothing done, where the evidence would
/// not rise by it, as it may not while terms still compete.
[[nodiscard]] bool reestimate_all(const MarginalLikelihood& likelihood, RvmState& s);

/// Algorithm 1 from the empty model as in [QZS23], with what else the selection asks for: after Selection::evidence
/// exchanges, and in ill-conditioned libraries detours and starts from all terms; the highest end is returned. Writes
/// status, steps, iterations and remarks into `fit`. Selection::type2, the paper's rule, has none of it: it would only
/// be moved to another of its many nearly equal ends.
[[nodiscard]] RvmState search(const MarginalLikelihood& likelihood, const FastRvmOptions& options, Fit& fit);

}  // namespace ident
