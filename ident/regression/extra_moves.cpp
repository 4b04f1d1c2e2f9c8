#include "ident/regression/extra_moves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/regression/fast_rvm.hpp"
#include "ident/regression/finish_fit.hpp"

namespace ident {
namespace {

using Eigen::Index;

// Beyond these variance inflations terms hide one another and a search from the empty model alone can stop short; two
// more starts are worth their time; the answer itself is in doubt.
constexpr double moderate_vif = 10.0, inflation_of_a_severe_library = 1e3, inflation_of_a_doubtful_one = 1e6;
// Libraries wider than this are not started from the full model: its QR grows with the cube of the width.
constexpr Index widest_full_start = 60;
// Largest lambda of a term in a full start, whatever is left of it beyond the others.
constexpr double lambda_at_rounding = 1e-28;
// An end counts as higher if its criterion is by more than the tolerance on log alpha leaves open.
constexpr double min_evidence_gain = 1e-6;

double size_of(const NoiseCovariance& noise) {
  const auto q = static_cast<double>(noise.variances.size());
  return noise.variances.array().pow(1.0 / q).prod();
}

// Every kept lambda at its best for this noise, all at once.
RvmState reestimated_at(const MarginalLikelihood& likelihood, const RvmState& s, NoiseCovariance noise) {
  RvmState all{s.kept, s.lambda, std::move(noise), {}};
  for (const Index term : s.kept)
    if (const double best = best_lambda(likelihood.factors(s.at, all.noise, term)); std::isfinite(best))
      all.set_lambda(term, best);
  likelihood.update_posterior(all);
  return all;
}

RvmState empty_start(const MarginalLikelihood& likelihood, const FastRvmOptions& options) {
  return likelihood.empty_state(options.initial_noise_fraction);
}

// All usable terms at their best lambda given all others: for libraries in which no term is conspicuous alone.
RvmState full_start(const MarginalLikelihood& likelihood, const FastRvmOptions& options) {
  RvmState s = empty_start(likelihood, options);
  s.kept = usable_terms(likelihood.problem());
  s.lambda.assign(s.kept.size(), flat_lambda);
  likelihood.update_posterior(s);
  s.noise = likelihood.residual_noise(s);
  for (const Index term : s.kept)
    s.set_lambda(term,
                 std::min(best_lambda(likelihood.factors(s, term)), std::max(s.at.sparsity(term), lambda_at_rounding)));
  likelihood.update_posterior(s);
  s.noise = likelihood.best_noise(s);
  return s;
}

// Backward elimination: drops the weakest term but `spared`, one after the other and nothing re-estimated but the
// noise, until all are worth keeping.
void thin_out(const MarginalLikelihood& likelihood, RvmState& s, Fit& fit, Index spared = -1) {
  while (!s.kept.empty()) {
    Index weakest = -1;
    for (const Index term : s.kept)
      if (term != spared && (weakest < 0 || likelihood.gain(s, term) < likelihood.gain(s, weakest))) weakest = term;
    if (weakest < 0 || likelihood.gain(s, weakest) > likelihood.tau()) return;
    make_move(likelihood, {FitAction::remove, weakest}, s);
    likelihood.record(s, {FitAction::remove, weakest}, fit);
  }
}

// Swaps one kept for one left-out term where that raises the criterion: of two nearly equal columns the first to come
// in may be the wrong one, and beside it the right one gains too little. True if it did.
bool exchange(const MarginalLikelihood& likelihood, RvmState& s, Fit& fit) {
  RvmMove best{FitAction::exchange, -1, likelihood.minimum_gain(s)};
  for (const Index leaving : s.kept) {
    RvmState without{s.kept, s.lambda, s.noise, {}};
    without.remove(leaving);
    likelihood.update_posterior(without);
    const double loss = likelihood.contribution(likelihood.factors(s, leaving), s.lambda_of(leaving));
    for (Index i = 0; i < likelihood.num_terms(); ++i) {
      const TermFactors term = likelihood.factors(without, i);
      if (s.keeps(i) || !likelihood.is_independent(term)) continue;
      const double gain = likelihood.gain(term) - loss;
      if (gain > best.gain) best = {FitAction::exchange, i, gain, leaving};
    }
  }
  if (best.term < 0) return false;
  s.remove(best.leaving);
  likelihood.update_posterior(s);
  make_move(likelihood, {FitAction::add, best.term}, s);
  likelihood.record(s, best, fit);
  return true;
}

// Forces one left-out term in and drops whatever others it makes weak: one term for several, which neither a move nor
// an exchange can reach. True, and `s` moved, if the best of these ends raises the criterion.
bool detour(const MarginalLikelihood& likelihood, RvmState& s, Fit& fit) {
  double highest = likelihood.criterion(s) + likelihood.minimum_gain(s);
  RvmState best;
  Fit best_path;
  for (Index i = 0; i < likelihood.num_terms(); ++i) {
    if (s.keeps(i) || !likelihood.is_independent(likelihood.factors(s, i))) continue;
    RvmState forced{s.kept, s.lambda, s.noise, {}};
    forced.add(i, flat_lambda);
    likelihood.update_posterior(forced);
    Fit path;
    likelihood.record(forced, {FitAction::add, i}, path);
    thin_out(likelihood, forced, path, i);
    if (likelihood.gain(forced, i) <= likelihood.tau()) continue;
    if (reestimate_all(likelihood, forced)) likelihood.update_posterior(forced);
    forced.noise = likelihood.best_noise(forced);
    likelihood.record(forced, {FitAction::reestimate, -1}, path);
    if (likelihood.criterion(forced) <= highest) continue;
    highest = likelihood.criterion(forced);
    best = std::move(forced);
    best_path = std::move(path);
  }
  if (best.kept.empty()) return false;
  s = std::move(best);
  fit.steps.insert(fit.steps.end(), best_path.steps.begin(), best_path.steps.end());
  fit.iterations += best_path.iterations;
  return true;
}

}  // namespace

bool reestimate_all(const MarginalLikelihood& likelihood, RvmState& s) {
  const double before = likelihood.log_evidence(s);
  // Where the fit is all but exact the noise falls only by b' / m a move; the residual says where it is going.
  if (NoiseCovariance ahead = likelihood.residual_noise(s); size_of(ahead) < 0.25 * size_of(s.noise)) {
    RvmState all = reestimated_at(likelihood, s, std::move(ahead));
    all.noise = likelihood.best_noise(all);
    if (likelihood.log_evidence(all) >= before) {
      s.lambda = std::move(all.lambda);
      return true;
    }
  }
  RvmState all = reestimated_at(likelihood, s, s.noise);
  if (likelihood.log_evidence(all) < before) return false;
  s.lambda = std::move(all.lambda);
  return true;
}

RvmState search(const MarginalLikelihood& likelihood, const FastRvmOptions& options, Fit& fit) {
  const UnitProblem& problem = likelihood.problem();
  const bool evidence = options.selection != Selection::type2;
  const bool many_rows = problem.num_samples > problem.num_terms() && problem.num_terms() <= widest_full_start;
  const double inflation = evidence && many_rows ? largest_inflation(problem) : 1.0;
  const bool hard = inflation > moderate_vif, severe = inflation > inflation_of_a_severe_library;
  const auto run = [&](RvmState s, bool thinned, Fit& path) {
    likelihood.record(s, {FitAction::start, -1}, path);
    path.iterations = 0;
    path.steps.back().terms = s.kept;
    if (thinned) thin_out(likelihood, s, path);
    do climb(likelihood, options, s, path);
    while (evidence && path.status == FitStatus::converged &&
           (exchange(likelihood, s, path) || (severe && detour(likelihood, s, path))));
    return s;
  };
  const Fit begun = fit;
  RvmState end = run(empty_start(likelihood, options), false, fit);
  for (const bool thinned : {false, true}) {
    if (!(thinned ? severe : hard)) break;
    Fit other = begun;
    RvmState other_end = run(full_start(likelihood, options), thinned, other);
    if (likelihood.criterion(other_end) > likelihood.criterion(end) + min_evidence_gain) {
      std::swap(fit, other);
      end = std::move(other_end);
    }
    fit.discarded_iterations += other.discarded_iterations + other.iterations;
  }
  if (inflation > inflation_of_a_doubtful_one)
    fit.remarks.push_back(fmt::format(
        "the candidate columns nearly depend on one another (largest variance inflation {:.2g}): other terms "
        "may explain the target as well",
        inflation));
  return end;
}

}  // namespace ident
