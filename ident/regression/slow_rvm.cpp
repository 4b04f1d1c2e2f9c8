#include <cmath>
#include <limits>
#include <stdexcept>

#include "ident/regression/describe.hpp"
#include "ident/regression/finish_fit.hpp"
#include "ident/regression/fit.hpp"
#include "ident/regression/posterior.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// A term whose lambda has grown this far beyond its sparsity contributes nothing: its coefficient is shrunk to zero.
constexpr double pruned_lambda = 1e6;

struct Fixed {
  std::vector<Index> kept;
  VectorXd lambda;
  double noise = 0.0;
};

void record(const UnitProblem& problem, const Fixed& s, const Posterior& at, FitAction action, Index term, Fit& fit) {
  fit.steps.push_back(
      {action, term, log_evidence(problem, at, s.noise), s.noise * problem.target_norm(0) * problem.target_norm(0)});
}

void drop(const UnitProblem& problem, Fixed& s, std::size_t j, Posterior& at, Fit& fit) {
  const auto index = static_cast<Index>(j), last = s.lambda.size() - 1;
  const Index term = s.kept[j];
  s.kept.erase(s.kept.begin() + static_cast<std::ptrdiff_t>(j));
  s.lambda.segment(index, last - index) = s.lambda.tail(last - index).eval();
  s.lambda.conservativeResize(last);
  at = posterior(problem, s.kept, s.lambda);
  record(problem, s, at, FitAction::remove, term, fit);
}

}  // namespace

Fit fit_slow_rvm(const RFactor& data, const SlowRvmOptions& options) {
  const UnitProblem problem = one_target(data, "fit_slow_rvm", options.poll);
  Fit fit;
  if (cannot_begin(problem, options, fit)) return fit;

  const auto m = static_cast<double>(problem.num_samples);
  const double floor = options.noise_floor_fraction / m;
  Fixed s;
  s.kept = usable_terms(problem);
  s.noise = options.initial_noise_fraction / m;
  // alpha = 1 / b for unit-norm columns: a prior wide enough to let every coefficient reach its place.
  s.lambda = VectorXd::Constant(static_cast<Index>(s.kept.size()), s.noise / static_cast<double>(problem.num_terms()));

  fit.status = FitStatus::iteration_limit;
  Posterior at = posterior(problem, s.kept, s.lambda);
  record(problem, s, at, FitAction::start, -1, fit);
  fit.steps.back().terms = s.kept;
  for (; fit.iterations < options.max_iterations; ++fit.iterations) {
    // Well-determinedness gamma_i = 1 - alpha_i delta_ii, alpha_i <- gamma_i / mu_i^2 ([Tip01], Eqs. 16-18).
    const VectorXd shrink = (s.lambda.array() * at.root.rowwise().squaredNorm().array()).matrix();
    const double settled_noise =
        std::max(floor, at.residual(0, 0) / (m - static_cast<double>(s.kept.size()) + shrink.sum()));
    double change = 0.0;
    std::size_t worst = s.kept.size();
    double worst_gain = fit.tau;
    for (std::size_t j = 0; j < s.kept.size(); ++j) {
      const auto index = static_cast<Index>(j);
      const double k = at.sparsity(s.kept[j]), l = at.quality(s.kept[j]);
      // gamma_i = k_i delta_ii without the subtraction.
      const double gamma = k * at.root.row(index).squaredNorm();
      const double lambda = settled_noise * gamma / (at.mean(index) * at.mean(index));
      change = std::max(change, std::abs(std::log(lambda / s.lambda(index))));
      s.lambda(index) = std::clamp(lambda, 1e-100, 1e30);
      const double gain = k > 0.0 ? evidence_gain(l * l / k / settled_noise) : 0.0;
      if (gain <= worst_gain) worst = j, worst_gain = gain;
    }
    const double noise_change = std::abs(std::log(settled_noise / s.noise));
    s.noise = settled_noise;
    at = posterior(problem, s.kept, s.lambda);
    record(problem, s, at, FitAction::reestimate, -1, fit);

    bool pruned = false;
    for (std::size_t j = s.kept.size(); j-- > 0;)
      if (!(s.lambda(static_cast<Index>(j)) < pruned_lambda)) drop(problem, s, j, at, fit), pruned = true;
    if (pruned) continue;
    // Terms on their way out never settle (their alpha grows for ever); whether they do so is known from their gain.
    const bool settled = change < options.log_alpha_tolerance && noise_change < options.log_alpha_tolerance;
    const bool calm = noise_change < 1e-3 && worst < s.kept.size();
    if (!settled && !calm) continue;
    if (worst == s.kept.size()) {
      fit.status = FitStatus::converged;
      break;
    }
    drop(problem, s, worst, at, fit);
  }
  finish_bayesian(problem, s.kept, s.lambda, s.noise, fit);
  return fit;
}

MethodDescription describe(const SlowRvmOptions& /*options*/) {
  return row<SlowRvmOptions, fit_slow_rvm>(Method::slow_rvm, "slow_rvm",
                                           "sparse Bayesian: all terms at first, the weakest pruned",
                                           rvm_settings<SlowRvmOptions>());
}

}  // namespace ident
