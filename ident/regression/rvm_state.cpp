#include "ident/regression/rvm_state.hpp"

#include <algorithm>
#include <cmath>

namespace ident {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// The flattest prior a coefficient is given: best lambdas go with the square of a sparsity, itself as small as the
// square of rounding.
constexpr double smallest_lambda = 1e-100;

std::ptrdiff_t index_of(const std::vector<Index>& kept, Index term) {
  return std::find(kept.begin(), kept.end(), term) - kept.begin();
}

}  // namespace

double RvmState::lambda_of(Index term) const {
  const auto index = static_cast<std::size_t>(index_of(kept, term));
  return index < kept.size() ? lambda[index] : std::numeric_limits<double>::infinity();
}

void RvmState::add(Index term, double its_lambda) {
  kept.push_back(term);
  lambda.push_back(std::max(its_lambda, smallest_lambda));
}

void RvmState::remove(Index term) {
  const std::ptrdiff_t index = index_of(kept, term);
  kept.erase(kept.begin() + index);
  lambda.erase(lambda.begin() + index);
}

void RvmState::set_lambda(Index term, double its_lambda) {
  lambda[static_cast<std::size_t>(index_of(kept, term))] = std::max(its_lambda, smallest_lambda);
}

MarginalLikelihood::MarginalLikelihood(const UnitProblem& problem, double tau, double noise_floor_fraction)
    : problem_(problem),
      tau_(tau),
      num_samples_(static_cast<double>(problem.num_samples)),
      num_targets_(static_cast<double>(problem.num_targets())),
      noise_floor_(noise_floor_fraction * (1.0 / num_samples_)),  // the mean square of a unit-norm target is 1 / m
      smallest_sparsity_(smallest_sparsity(problem)) {}

RvmState MarginalLikelihood::empty_state(double noise_fraction) const {
  const Index q = problem_.num_targets();
  RvmState s;
  s.noise = {MatrixXd::Identity(q, q), VectorXd::Constant(q, noise_fraction * (1.0 / num_samples_))};
  update_posterior(s);
  return s;
}

void MarginalLikelihood::update_posterior(RvmState& s) const {
  s.at = posterior(problem_, s.kept, s.lambdas());
}

NoiseCovariance MarginalLikelihood::best_noise(const RvmState& s) const {
  return NoiseCovariance::of(s.at.misfit, num_samples_, noise_floor_);
}

NoiseCovariance MarginalLikelihood::residual_noise(const RvmState& s) const {
  const double spare = num_samples_ - static_cast<double>(s.kept.size());
  return spare > 0.0 ? NoiseCovariance::of(s.at.residual, spare, noise_floor_) : s.noise;
}

double MarginalLikelihood::criterion(const RvmState& s) const {
  return 2.0 * log_evidence(s) - tau_ * static_cast<double>(s.kept.size());
}

double MarginalLikelihood::minimum_gain(const RvmState& s) const {
  return 1e-9 + 16.0 * std::numeric_limits<double>::epsilon() * std::abs(criterion(s));
}

TermFactors MarginalLikelihood::factors(const Posterior& at, const NoiseCovariance& noise, Index term) const {
  const Index q = problem_.num_targets();
  double sum = 0.0;
  for (Index axis = 0; axis < q; ++axis) {
    double along = 0.0;
    for (Index t = 0; t < q; ++t) along += at.quality(term, t) * noise.axes(t, axis);
    sum += along * along / noise.variances(axis);
  }
  return {at.sparsity(term), sum / num_targets_};
}

double MarginalLikelihood::gain(const TermFactors& term) const {
  return is_independent(term) ? num_targets_ * evidence_gain(term.quality2 / term.sparsity) : 0.0;
}

double MarginalLikelihood::contribution(const TermFactors& term, double lambda) const {
  return num_targets_ * evidence_contribution(term.sparsity, term.quality2, lambda);
}

void MarginalLikelihood::record(const RvmState& s, const RvmMove& move, Fit& fit) const {
  double variance = 1.0;  // the geometric mean over the axes of the noise
  for (Index t = 0; t < problem_.num_targets(); ++t)
    variance *= std::pow(s.noise.variances(t) * problem_.target_norm(t) * problem_.target_norm(t), 1.0 / num_targets_);
  ++fit.iterations;
  fit.steps.push_back({move.action, move.term, log_evidence(s), variance, move.leaving});
}

}  // namespace ident
