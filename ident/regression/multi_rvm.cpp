#include "ident/regression/multi_rvm.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "ident/regression/describe.hpp"
#include "ident/regression/extra_moves.hpp"
#include "ident/regression/finish_fit.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

FastRvmOptions as_fast(const MultiRvmOptions& options, double tau) {
  return {options.selection,
          tau,
          options.max_iterations,
          options.log_alpha_tolerance,
          options.initial_noise_fraction,
          options.noise_floor_fraction,
          options.poll};
}

UnitProblem one_of(const UnitProblem& problem, Index target) {
  UnitProblem one = problem;
  one.Y = MatrixXd(problem.Y.col(target));
  one.target_norm = VectorXd(problem.target_norm.segment(target, 1));
  return one;
}

// The end of the shared search in the caller's units, terms ascending.
void fill_in(const MarginalLikelihood& likelihood, const RvmState& end, MultiFit& fit) {
  const UnitProblem& problem = likelihood.problem();
  std::vector<std::size_t> order(end.kept.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return end.kept[a] < end.kept[b]; });
  const auto n = static_cast<Index>(end.kept.size());
  fit.mean.resize(n, problem.num_targets());
  fit.lambda.resize(n);
  MatrixXd root(n, n);
  for (Index i = 0; i < n; ++i) {
    const std::size_t from = order[static_cast<std::size_t>(i)];
    const double norm = problem.column_norm(end.kept[from]);
    fit.relevant.push_back(end.kept[from]);
    fit.lambda(i) = end.lambda[from] * norm * norm;
    root.row(i) = end.at.root.row(static_cast<Index>(from)) / norm;
    fit.mean.row(i) = end.at.mean.row(static_cast<Index>(from)).cwiseProduct(problem.target_norm.transpose()) / norm;
  }
  fit.row_covariance = root * root.transpose();
  fit.noise_covariance = problem.target_norm.asDiagonal() * end.noise.matrix() * problem.target_norm.asDiagonal();
  fit.log_evidence = likelihood.log_evidence(end);
  if (n == 0) fit.status = FitStatus::no_relevant_term;
}

// One target has nothing to share: the whole search of fit_fast_rvm, in this vocabulary.
MultiFit of_one_target(Fit row) {
  MultiFit fit;
  fit.status = row.status;
  fit.relevant = row.relevant;
  fit.mean = row.mean;
  fit.row_covariance = row.covariance / row.noise_variance;
  fit.noise_covariance = MatrixXd::Constant(1, 1, row.noise_variance);
  fit.lambda = row.alpha * row.noise_variance;
  fit.log_evidence = row.log_evidence;
  fit.tau = row.tau;
  fit.iterations = row.iterations;
  fit.steps = row.steps;
  row.method = Method::multi_rvm;
  fit.rows.push_back(std::move(row));
  return fit;
}

// Every row ends as the shared fit did, which kept nothing.
MultiFit without_terms(MultiFit fit, const UnitProblem& shared, const Fit& begun) {
  for (Index j = 0; j < shared.num_targets(); ++j) {
    const UnitProblem problem = one_of(shared, j);
    Fit row = begun;
    if (!cannot_begin(problem, row))
      finish_bayesian(problem, {}, VectorXd(), 1.0 / static_cast<double>(problem.num_samples), row);
    row.status = fit.status;
    fit.rows.push_back(std::move(row));
  }
  return fit;
}

// As one of the methods for one target.
Fit fit_one_target(const RFactor& data, const MultiRvmOptions& options) {
  if (data.num_targets() != 1) throw std::invalid_argument("fit: needs one target; fit_multi_rvm takes several");
  return fit_multi_rvm(data, options).rows.front();
}

}  // namespace

MatrixXd MultiFit::standard_deviation() const {
  return (row_covariance.diagonal() * noise_covariance.diagonal().transpose()).cwiseSqrt();
}

MultiFit fit_multi_rvm(const RFactor& data, const MultiRvmOptions& options) {
  if (data.num_targets() == 1) return of_one_target(fit_fast_rvm(data, as_fast(options, options.tau)));
  const UnitProblem problem = unit_problem(data, options.poll);
  MultiFit fit;
  Fit shared;
  for (Index j = 0; j < data.num_targets() && fit.status == FitStatus::converged; ++j)
    if (cannot_begin(one_of(problem, j), options, shared)) fit.status = shared.status;
  fit.tau = shared.tau;
  if (fit.status != FitStatus::converged) return without_terms(std::move(fit), problem, shared);

  const MarginalLikelihood likelihood(problem, fit.tau, options.noise_floor_fraction);
  const FastRvmOptions alone = as_fast(options, fit.tau);
  Fit path = shared;
  const RvmState end = search(likelihood, alone, path);
  fit.status = path.status;
  fit.iterations = path.iterations;
  fit.steps = std::move(path.steps);
  fill_in(likelihood, end, fit);
  if (fit.relevant.empty()) return without_terms(std::move(fit), problem, shared);

  for (Index j = 0; j < data.num_targets(); ++j) {
    fit.rows.push_back(fit_fast_rvm(select(data, fit.relevant, j), alone));
    fit.rows.back().method = Method::multi_rvm;
    renumber(fit.rows.back(), fit.relevant, data.num_terms);
  }
  return fit;
}

MethodDescription describe(const MultiRvmOptions& /*options*/) {
  return row<MultiRvmOptions, fit_one_target>(Method::multi_rvm, "multi_rvm",
                                              "fast_rvm for targets that share their terms; of one target the same",
                                              rvm_settings<MultiRvmOptions>());
}

}  // namespace ident
