#pragma once
#include "ident/regression/fit.hpp"
#include "ident/regression/rvm_state.hpp"

namespace ident {

/// Steps 5 to 58 of Algorithm 1 of [QZS23]: the best move, again and again, until every lambda has settled and nothing
/// can be added or removed. Each move is recorded in `fit`, whose status says if the iterations ran out.
void climb(const MarginalLikelihood& likelihood, const FastRvmOptions& options, RvmState& s, Fit& fit);

/// Steps 28 to 56: makes an addition, removal or re-estimation.
void make_move(const MarginalLikelihood& likelihood, const RvmMove& move, RvmState& s);

}  // namespace ident
