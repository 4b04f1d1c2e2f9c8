#pragma once
#include <Eigen/Core>
#include <limits>
#include <vector>

#include "ident/regression/fit.hpp"
#include "ident/regression/posterior.hpp"

namespace ident {

/// A state of the search of a fast RVM: the kept terms with their lambda, the noise, and the posterior given both.
struct RvmState {
  std::vector<Eigen::Index> kept;  ///< b' terms in the order they came in
  std::vector<double> lambda;      ///< b'
  NoiseCovariance noise;           ///< of the unit-norm targets
  Posterior at;

  /// Infinite for a term that is not kept, as alpha is in Algorithm 1 of [QZS23].
  [[nodiscard]] double lambda_of(Eigen::Index term) const;
  [[nodiscard]] bool keeps(Eigen::Index term) const {
    return lambda_of(term) < std::numeric_limits<double>::infinity();
  }
  void add(Eigen::Index term, double its_lambda);
  void remove(Eigen::Index term);
  void set_lambda(Eigen::Index term, double its_lambda);
  [[nodiscard]] Eigen::Map<const Eigen::VectorXd> lambdas() const& {
    return {lambda.data(), static_cast<Eigen::Index>(lambda.size())};
  }
  void lambdas() const&& = delete;
};

struct RvmMove {
  FitAction action = FitAction::reestimate;
  Eigen::Index term = -1;     ///< -1: there is none
  double gain = 0.0;          ///< of the criterion
  Eigen::Index leaving = -1;  ///< of an exchange
};

/// What the marginal likelihood says of one term given all others, noise-scaled: sigma^2 k and sigma^2 l^2 (Eqs. 22-23
/// of [QZS23]); for q targets with one relevance per term, l Omega^-1 l' / q in place of l^2 / sigma^2.
struct TermFactors {
  double sparsity = 0.0, quality2 = 0.0;
};

/// Eqs. 29-30 of [QZS23]; infinite where l^2 <= k.
[[nodiscard]] inline double best_lambda(const TermFactors& term) {
  return best_lambda(term.sparsity, term.quality2);
}

/// The marginal likelihood (Eq. 15 of [QZS23]) of q targets as a function of a state. Gains are 2 dL, of all targets
/// together: Eqs. 21, 29 and 32-34 hold with TermFactors, times q. Keeps a reference to `problem`.
class MarginalLikelihood {
 public:
  /// `noise_floor_fraction`: of a target's mean square, below which no noise is believed.
  MarginalLikelihood(const UnitProblem& problem, double tau, double noise_floor_fraction);

  [[nodiscard]] const UnitProblem& problem() const& { return problem_; }
  void problem() const&& = delete;
  [[nodiscard]] double tau() const { return tau_; }
  [[nodiscard]] Eigen::Index num_terms() const { return problem_.num_terms(); }

  /// Steps 2 to 4 of Algorithm 1: no term, and as noise this fraction (gamma) of each target's mean square.
  [[nodiscard]] RvmState empty_state(double noise_fraction) const;
  /// The posterior at the state's terms and lambda.
  void update_posterior(RvmState& s) const;
  /// For fixed lambda the evidence is highest over sigma^2 (Omega, for several targets) here.
  [[nodiscard]] NoiseCovariance best_noise(const RvmState& s) const;
  /// The unbiased estimate from the residual; the state's own where there are no more rows than terms.
  [[nodiscard]] NoiseCovariance residual_noise(const RvmState& s) const;

  [[nodiscard]] double log_evidence(const RvmState& s) const { return ident::log_evidence(problem_, s.at, s.noise); }
  /// What the search climbs: 2 log evidence - tau x number of terms.
  [[nodiscard]] double criterion(const RvmState& s) const;
  /// A criterion of size L is known to about eps L; a move must beat that, or the search could cycle on rounding.
  [[nodiscard]] double minimum_gain(const RvmState& s) const;

  [[nodiscard]] TermFactors factors(const Posterior& at, const NoiseCovariance& noise, Eigen::Index term) const;
  [[nodiscard]] TermFactors factors(const RvmState& s, Eigen::Index term) const { return factors(s.at, s.noise, term); }
  /// False where the term is the rounding of kept ones.
  [[nodiscard]] bool is_independent(const TermFactors& term) const { return term.sparsity > smallest_sparsity_; }
  /// Of having the term at its best lambda instead of not at all (Eq. 32); zero where l^2 <= k, or not independent.
  [[nodiscard]] double gain(const TermFactors& term) const;
  [[nodiscard]] double gain(const RvmState& s, Eigen::Index term) const { return gain(factors(s, term)); }
  /// Of having the term at this lambda instead of not at all.
  [[nodiscard]] double contribution(const TermFactors& term, double lambda) const;

  /// Counts the move, and writes down the state after it.
  void record(const RvmState& s, const RvmMove& move, Fit& fit) const;

 private:
  const UnitProblem& problem_;
  double tau_, num_samples_, num_targets_, noise_floor_, smallest_sparsity_;
};

}  // namespace ident
