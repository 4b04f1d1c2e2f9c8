#pragma once
#include <Eigen/Core>
#include <limits>
#include <vector>

#include "ident/fit.hpp"
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
  [[nodiscard]] Eigen::Map<const Eigen::VectorXd> lambdas() const {
    return {lambda.data(), static_cast<Eigen::Index>(lambda.size())};
  }
};

struct RvmMove {
  FitAction action = FitAction::reestimate;
  Eigen::Index term = -1;     ///< -1: there is none
  double gain = 0.0;          ///< of the criterion
  Eigen::Index leaving = -1;  ///< of an exchange
};

/// The marginal likelihood (Eq. 15 of [QZS23]) of q targets as a function of a state, and what it says of each term
/// given all others. Gains are 2 dL; where targets share one relevance per term, Eqs. 21, 29 and 32-34 hold with
/// l^2 / q = l Omega^-1 l' / q in place of l^2, times q. Keeps a reference to `problem`.
class MarginalLikelihood {
 public:
  /// `noise_floor_fraction`: of a target's mean square, below which no noise is believed.
  MarginalLikelihood(const UnitProblem& problem, double tau, double noise_floor_fraction);

  [[nodiscard]] const UnitProblem& problem() const { return problem_; }
  [[nodiscard]] double tau() const { return tau_; }
  [[nodiscard]] Eigen::Index num_terms() const { return problem_.num_terms(); }

  /// No term, and as noise this fraction of each target's mean square.
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

  /// False where the term is the rounding of kept ones.
  [[nodiscard]] bool is_independent(const RvmState& s, Eigen::Index term) const;
  /// Of having the term at its best lambda instead of not at all (Eq. 32); zero where l^2 <= k, or not independent.
  [[nodiscard]] double gain(const RvmState& s, Eigen::Index term) const;
  /// Of having the term at this lambda instead of not at all.
  [[nodiscard]] double share(const RvmState& s, Eigen::Index term, double lambda) const;
  /// Eqs. 29-30, infinite where l^2 <= k.
  [[nodiscard]] double best_lambda(const RvmState& s, Eigen::Index term) const;

  /// Counts the move, and writes down the state after it.
  void record(const RvmState& s, const RvmMove& move, Fit& fit) const;

 private:
  [[nodiscard]] double quality2(const RvmState& s, Eigen::Index term) const;

  const UnitProblem& problem_;
  double tau_, num_samples_, num_targets_, noise_floor_, smallest_sparsity_;
};

}  // namespace ident
