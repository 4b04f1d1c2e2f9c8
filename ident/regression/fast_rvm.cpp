#include "ident/regression/fast_rvm.hpp"

#include <cmath>

#include "ident/regression/describe.hpp"
#include "ident/regression/extra_moves.hpp"
#include "ident/regression/finish_fit.hpp"

// Algorithm 1 of [QZS23], which is that of [TF03], with its steps and equations by their numbers there. It differs in:
// - a term must gain more than tau (2 dL), where step 8 takes any gain (l^2 > k): tau = 0 is the paper's rule;
// - convergence is asked of every lambda, not of the chosen one alone (steps 30-41);
// - what else is tried before and after is in extra_moves.hpp;
// - all in noise-scaled lambda = alpha sigma^2, for which sigma^2 has a closed form with the same stationary points as
//   step 54 (where b is a misprint of b'), and k, l from a QR in place of Eqs. 24-27, which break down at little noise;
// - Eq. 32 is printed without the square of l' under its logarithm.

namespace ident {
namespace {

using Eigen::Index;

// Steps 6 to 27.
RvmMove best_move(const MarginalLikelihood& likelihood, const FastRvmOptions& options, const RvmState& s) {
  RvmMove best{FitAction::reestimate, -1, likelihood.minimum_gain(s)}, unsettled;
  double largest_change = options.log_alpha_tolerance;
  for (Index i = 0; i < likelihood.num_terms(); ++i) {
    const TermFactors term = likelihood.factors(s, i);  // step 7
    const double lambda = s.lambda_of(i);
    const bool kept = std::isfinite(lambda);
    RvmMove move{FitAction::reestimate, i};
    if (const double gain = likelihood.gain(term); gain > likelihood.tau()) {                       // step 8
      if (kept) {                                                                                   // steps 9-12
        const double better = best_lambda(term);                                                    // Eq. 29
        move.gain = likelihood.contribution(term, better) - likelihood.contribution(term, lambda);  // Eq. 34
        const double change = std::abs(std::log(better / lambda));                                  // step 30
        if (change > largest_change) largest_change = change, unsettled = move;
      } else {  // steps 13-15
        move.action = FitAction::add;
        move.gain = gain - likelihood.tau();  // Eq. 32
      }
    } else if (kept) {  // steps 18-20
      move.action = FitAction::remove;
      move.gain = likelihood.tau() - likelihood.contribution(term, lambda);  // Eq. 33
    }
    if (move.gain > best.gain) best = move;  // step 27
  }
  return best.term >= 0 ? best : unsettled;  // neither: converged, steps 31-41
}

}  // namespace

void make_move(const MarginalLikelihood& likelihood, const RvmMove& move, RvmState& s) {
  const double lambda = best_lambda(likelihood.factors(s, move.term));  // Eq. 29
  if (move.action == FitAction::add)                                    // steps 44-47
    s.add(move.term, lambda);
  else if (move.action == FitAction::remove)  // steps 48-51
    s.remove(move.term);
  else if (!reestimate_all(likelihood, s))  // steps 29-43
    s.set_lambda(move.term, lambda);
  likelihood.update_posterior(s);      // step 56, Eqs. 12-13
  s.noise = likelihood.best_noise(s);  // step 54
}

void climb(const MarginalLikelihood& likelihood, const FastRvmOptions& options, RvmState& s, Fit& fit) {
  while (fit.iterations < options.max_iterations) {  // step 5
    const RvmMove move = best_move(likelihood, options, s);
    if (move.term < 0) {
      s.noise = likelihood.best_noise(s);  // an end that is still the empty start has the initial guess
      return;
    }
    make_move(likelihood, move, s);
    likelihood.record(s, move, fit);  // step 57
  }
  fit.status = FitStatus::iteration_limit;
}

Fit fit_fast_rvm(const RFactor& data, const FastRvmOptions& options) {
  Fit fit;
  const UnitProblem problem = one_target(data, "fit_fast_rvm", options.poll);
  if (cannot_begin(problem, options, fit)) return fit;
  const RvmState end = search({problem, fit.tau, options.noise_floor_fraction}, options, fit);
  finish_bayesian(problem, end.kept, end.lambdas(), end.noise.variances(0), fit);
  return fit;
}

MethodDescription describe(const FastRvmOptions& /*options*/) {
  return row<FastRvmOptions, fit_fast_rvm>(Method::fast_rvm, "fast_rvm",
                                           "sparse Bayesian: terms come, go and are exchanged one by one",
                                           rvm_settings<FastRvmOptions>());
}

}  // namespace ident
