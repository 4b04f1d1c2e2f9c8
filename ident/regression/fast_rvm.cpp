#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "ident/fit.hpp"
#include "ident/regression/finish_fit.hpp"
#include "ident/regression/posterior.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Where the search stands: kept terms with their lambda, the noise, and what the marginal likelihood says of all terms.
struct Standing {
  std::vector<Index> kept;
  std::vector<double> lambda;
  double noise = 0.0;
  Posterior at;
};

struct Move {
  FitAction action = FitAction::reestimate;
  Index term = -1;
  double gain = 0.0;   ///< of the criterion 2 log evidence - tau x number of terms
  Index leaving = -1;  ///< of an exchange
};

// A prior that lets a coefficient go where the data want it, and the flattest there is: best lambdas go with the square
// of a sparsity, itself as small as the square of rounding.
constexpr double flat = 1e-30, smallest_lambda = 1e-100;

class Search {
 public:
  Search(const UnitProblem& problem, const FastRvmOptions& options, double tau)
      : problem_(problem), options_(options), tau_(tau) {
    const double mean_square = 1.0 / static_cast<double>(problem.num_samples);  // of the unit-norm target
    noise_floor_ = options.noise_floor_fraction * mean_square;
    initial_noise_ = options.initial_noise_fraction * mean_square;
    // A column this close to the span of the others is rounding, not information.
    smallest_sparsity_ =
        std::pow(4.0 * std::numeric_limits<double>::epsilon(), 2) * static_cast<double>(problem.A.rows());
  }

  Standing from_empty() const {
    Standing s;
    s.noise = initial_noise_;
    look(s);
    return s;
  }

  // All usable terms at their best lambda given all others: for libraries in which no term stands out alone.
  Standing from_full() const {
    Standing s;
    s.kept = usable_terms(problem_);
    s.lambda.assign(s.kept.size(), flat);
    look(s);
    const auto spare = static_cast<double>(problem_.num_samples - static_cast<Index>(s.kept.size()));
    s.noise = std::max(noise_floor_, s.at.residual / spare);
    for (std::size_t j = 0; j < s.kept.size(); ++j) {
      const Index term = s.kept[j];
      const double best = best_lambda(s.at.sparsity(term), s.at.quality(term), s.noise);
      s.lambda[j] = std::clamp(best, smallest_lambda, std::max(s.at.sparsity(term), 1e-28));
    }
    look(s);
    s.noise = noise_of(s);
    return s;
  }

  void open(const Standing& s, Fit& fit) const {
    record(s, {FitAction::start, -1}, fit);
    fit.iterations = 0;
    fit.steps.back().terms = s.kept;
  }

  // Drops the weakest term but `spared`, one after the other and nothing re-estimated but the noise, until all are
  // worth keeping.
  void thin_out(Standing& s, Fit& fit, Index spared = -1) const {
    while (!s.kept.empty()) {
      Index weakest = -1;
      for (const Index term : s.kept)
        if (term != spared && (weakest < 0 || strength(s, term) < strength(s, weakest))) weakest = term;
      if (weakest < 0 || strength(s, weakest) > tau_) return;
      const Move move{FitAction::remove, weakest, 0.0};
      apply(s, move);
      record(s, move, fit);
    }
  }

  // Algorithm 1 of [QZS23]: the best move, until every lambda has settled and nothing can be added or removed.
  void climb(Standing& s, Fit& fit) const {
    while (fit.iterations < options_.max_iterations) {
      const Move move = best_move(s);
      if (move.term < 0) {
        s.noise = noise_of(s);  // an end that is still the empty start has the initial guess
        return;
      }
      apply(s, move);
      record(s, move, fit);
    }
    fit.status = FitStatus::iteration_limit;
  }

  // Swaps one kept for one left-out term where that raises the criterion. True if it did.
  bool exchange(Standing& s, Fit& fit) const {
    Move best{FitAction::exchange, -1, minimum_gain(s)};
    std::size_t leaving = 0;
    for (std::size_t j = 0; j < s.kept.size(); ++j) {
      Standing without = s;
      without.kept.erase(without.kept.begin() + static_cast<std::ptrdiff_t>(j));
      without.lambda.erase(without.lambda.begin() + static_cast<std::ptrdiff_t>(j));
      look(without);
      const double loss = evidence_share(s, s.kept[j], s.lambda[j]);
      for (Index i = 0; i < problem_.num_terms(); ++i) {
        if (i == s.kept[j] || is_kept(without, i) || without.at.sparsity(i) <= smallest_sparsity_) continue;
        const double gain = evidence_gain(q(without, i)) - loss;
        if (gain > best.gain) best = {FitAction::exchange, i, gain, s.kept[j]}, leaving = j;
      }
    }
    if (best.term < 0) return false;
    s.kept.erase(s.kept.begin() + static_cast<std::ptrdiff_t>(leaving));
    s.lambda.erase(s.lambda.begin() + static_cast<std::ptrdiff_t>(leaving));
    look(s);
    apply(s, {FitAction::add, best.term, best.gain});
    record(s, best, fit);
    return true;
  }

  // Forces one left-out term in and drops whatever others it makes weak: one term for several, which neither a move
  // nor an exchange can reach. True, and `s` moved, if the best of these ends raises the criterion.
  bool detour(Standing& s, Fit& fit) const {
    double best_criterion = criterion(s) + minimum_gain(s);
    Standing best;
    Fit best_path;
    for (Index i = 0; i < problem_.num_terms(); ++i) {
      if (is_kept(s, i) || s.at.sparsity(i) <= smallest_sparsity_) continue;
      Standing forced = s;
      forced.kept.push_back(i);
      forced.lambda.push_back(flat);
      look(forced);
      Fit path;
      record(forced, {FitAction::add, i}, path);
      thin_out(forced, path, i);
      if (strength(forced, i) <= tau_) continue;
      if (settle_all(forced)) look(forced);
      forced.noise = noise_of(forced);
      record(forced, {FitAction::reestimate, -1}, path);
      if (criterion(forced) <= best_criterion) continue;
      best_criterion = criterion(forced);
      best = std::move(forced);
      best_path = std::move(path);
    }
    if (best.kept.empty()) return false;
    s = std::move(best);
    fit.steps.insert(fit.steps.end(), best_path.steps.begin(), best_path.steps.end());
    fit.iterations += best_path.iterations;
    return true;
  }

  double criterion(const Standing& s) const {
    return 2.0 * log_evidence(problem_, s.at, s.noise) - tau_ * static_cast<double>(s.kept.size());
  }

 private:
  void look(Standing& s) const {
    s.at =
        posterior(problem_, s.kept, Eigen::Map<const VectorXd>(s.lambda.data(), static_cast<Index>(s.lambda.size())));
  }

  static bool is_kept(const Standing& s, Index term) {
    return std::find(s.kept.begin(), s.kept.end(), term) != s.kept.end();
  }
  static double q(const Standing& s, Index term) {
    return s.at.quality(term) * s.at.quality(term) / s.at.sparsity(term) / s.noise;
  }
  // Gain of having a term; none where it is the rounding of others.
  double strength(const Standing& s, Index term) const {
    return s.at.sparsity(term) > smallest_sparsity_ ? evidence_gain(q(s, term)) : 0.0;
  }
  static double evidence_share(const Standing& s, Index term, double lambda) {
    return ident::evidence_share(s.at.sparsity(term), s.at.quality(term), lambda, s.noise);
  }
  // A criterion of size L is known to about eps L; a move must beat that, or the search could cycle on rounding.
  double minimum_gain(const Standing& s) const {
    return 1e-9 + 16.0 * std::numeric_limits<double>::epsilon() * std::abs(criterion(s));
  }

  Move best_move(const Standing& s) const {
    Move best{FitAction::reestimate, -1, minimum_gain(s)};
    Move settle;
    double largest_change = options_.log_alpha_tolerance;
    for (std::size_t j = 0; j < s.kept.size(); ++j) {
      const Index term = s.kept[j];
      const double share = evidence_share(s, term, s.lambda[j]);
      if (s.at.sparsity(term) <= smallest_sparsity_ || evidence_gain(q(s, term)) <= tau_) {
        if (tau_ - share > best.gain) best = {FitAction::remove, term, tau_ - share};
        continue;
      }
      const double lambda = best_lambda(s.at.sparsity(term), s.at.quality(term), s.noise);
      const double gain = evidence_share(s, term, lambda) - share;
      if (gain > best.gain) best = {FitAction::reestimate, term, gain};
      const double change = std::abs(std::log(lambda / s.lambda[j]));
      if (change > largest_change) largest_change = change, settle = {FitAction::reestimate, term, gain};
    }
    for (Index i = 0; i < problem_.num_terms(); ++i) {
      if (is_kept(s, i) || s.at.sparsity(i) <= smallest_sparsity_) continue;
      const double gain = evidence_gain(q(s, i)) - tau_;
      if (gain > best.gain) best = {FitAction::add, i, gain};
    }
    return best.term >= 0 ? best : settle;
  }

  void apply(Standing& s, const Move& move) const {
    const double lambda = best_lambda(s.at.sparsity(move.term), s.at.quality(move.term), s.noise);
    const auto place = std::find(s.kept.begin(), s.kept.end(), move.term);
    const auto index = place - s.kept.begin();
    if (move.action == FitAction::add) {
      s.kept.push_back(move.term);
      s.lambda.push_back(std::max(lambda, smallest_lambda));
    } else if (move.action == FitAction::remove) {
      s.kept.erase(place);
      s.lambda.erase(s.lambda.begin() + index);
    } else if (!settle_all(s)) {
      s.lambda[static_cast<std::size_t>(index)] = std::max(lambda, smallest_lambda);
    }
    look(s);
    // For fixed lambda the evidence has its maximum over sigma^2 here: same stationary points as step 54.
    s.noise = noise_of(s);
  }

  double noise_of(const Standing& s) const {
    return std::max(noise_floor_, s.at.misfit / static_cast<double>(problem_.num_samples));
  }

  // Every kept lambda at its best for this noise, all at once.
  Standing settled_at(const Standing& s, double noise) const {
    Standing all = s;
    all.noise = noise;
    for (std::size_t j = 0; j < s.kept.size(); ++j) {
      const double best = best_lambda(s.at.sparsity(s.kept[j]), s.at.quality(s.kept[j]), noise);
      if (std::isfinite(best)) all.lambda[j] = std::max(best, smallest_lambda);
    }
    look(all);
    return all;
  }

  // Re-estimates every kept lambda at once: far fewer moves than one by one. False, and nothing done, where the
  // evidence would not rise by it, as it may not while terms still compete.
  bool settle_all(Standing& s) const {
    const double before = log_evidence(problem_, s.at, s.noise);
    const auto spare = static_cast<double>(problem_.num_samples - static_cast<Index>(s.kept.size()));
    const double told = spare > 0.0 ? std::max(noise_floor_, s.at.residual / spare) : s.noise;
    // Where the fit is all but exact the noise falls only by b' / m a move; the residual tells where it is going.
    if (told < 0.25 * s.noise) {
      Standing all = settled_at(s, told);
      if (log_evidence(problem_, all.at, noise_of(all)) >= before) {
        s.lambda = std::move(all.lambda);
        return true;
      }
    }
    Standing all = settled_at(s, s.noise);
    if (log_evidence(problem_, all.at, s.noise) < before) return false;
    s.lambda = std::move(all.lambda);
    return true;
  }

  void record(const Standing& s, const Move& move, Fit& fit) const {
    ++fit.iterations;
    fit.steps.push_back({move.action, move.term, log_evidence(problem_, s.at, s.noise),
                         s.noise * problem_.target_norm * problem_.target_norm, move.leaving});
  }

  const UnitProblem& problem_;
  const FastRvmOptions& options_;
  double tau_, noise_floor_ = 0.0, initial_noise_ = 0.0, smallest_sparsity_ = 0.0;
};

// Beyond these variance inflations two more starts are worth their time, and the answer itself is in doubt.
constexpr double inflation_of_a_severe_library = 1e3, inflation_of_a_doubtful_one = 1e6;

}  // namespace

Fit fit_fast_rvm(const RFactor& data, const FastRvmOptions& options) {
  if (!(options.initial_noise_fraction > 0.0 && options.initial_noise_fraction < 1.0))
    throw std::invalid_argument("fit_fast_rvm: initial_noise_fraction must be in (0, 1)");
  const UnitProblem problem = unit_problem(data);
  Fit fit;
  fit.method = Method::fast_rvm;
  if (cannot_begin(problem, fit)) return fit;
  if (options.tau >= 0.0)
    fit.tau = options.tau;
  else if (options.selection == Selection::evidence)
    fit.tau = default_tau(problem.num_samples, problem.num_terms());

  const Search search(problem, options, fit.tau);
  // The paper's rule has no exchange, detour or second start; they would only move it to another of its many near-equal
  // ends.
  const bool evidence = options.selection == Selection::evidence;
  const double inflation =
      evidence && problem.num_terms() <= widest_full_start && problem.num_samples > problem.num_terms()
          ? largest_inflation(problem)
          : 1.0;
  const bool hard = inflation > inflation_of_a_hard_library, severe = inflation > inflation_of_a_severe_library;
  const auto run = [&](Standing s, bool thinned, Fit& record) {
    search.open(s, record);
    if (thinned) search.thin_out(s, record);
    do search.climb(s, record);
    while (evidence && record.status == FitStatus::converged &&
           (search.exchange(s, record) || (severe && search.detour(s, record))));
    return s;
  };
  Standing end = run(search.from_empty(), false, fit);
  for (const bool thinned : {false, true}) {
    if (!(thinned ? severe : hard)) break;
    Fit other;
    other.method = Method::fast_rvm;
    other.tau = fit.tau;
    Standing other_end = run(search.from_full(), thinned, other);
    const bool higher = search.criterion(other_end) > search.criterion(end) + 1e-6;
    if (higher) {
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
  finish_bayesian(problem, end.kept,
                  Eigen::Map<const VectorXd>(end.lambda.data(), static_cast<Index>(end.lambda.size())), end.noise, fit);
  return fit;
}

}  // namespace ident
