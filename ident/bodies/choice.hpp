#pragma once
#include <vector>

#include "ident/bodies/bodies.hpp"
#include "ident/bodies/statement.hpp"
#include "ident/state_space/select.hpp"
#include "ident/validate/range_result.hpp"

namespace ident {

/// A record in a frame, and what its likelihood chose there.
struct Choice {
  BodiesRecord record;
  BodiesLayout layout = {};
  std::vector<BodyTerm> candidates = {};
  BodiesStatement statement = {};
  state_space::Selection selection = {};
  /// Nothing is left that the equations do not explain.
  [[nodiscard]] bool is_complete() const {
    return selection.fit.converged() && selection.fit.gain_of_process_noise < Likelihood::beyond_doubt;
  }
};

/// The force on an imposed motion from the training samples of `result`, which learns what a hysteretic part z gained:
/// least squares of f over the candidates and z, which runs on its own (state_space::output_error), terms dropped
/// while -2 log likelihood rises by less than their price. What is left comes back in every cycle: rows count as often
/// as the residual's autocorrelation lets them.
[[nodiscard]] Choice choose_force(const BodiesRecord& record, const BodiesOptions& options, BodiesResult& result);

}  // namespace ident
