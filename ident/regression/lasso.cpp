#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "dsp/values/constants.hpp"
#include "ident/regression/describe.hpp"
#include "ident/regression/finish_fit.hpp"
#include "ident/regression/fit.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

using dsp::nan;

// Minimises ||y - A c||^2 / 2 + penalty ||c||_1 for unit-norm columns, from `c`. False: it had not settled.
bool coordinate_descent(const UnitProblem& problem, double penalty, VectorXd& c) {
  VectorXd residual = problem.Y.col(0) - problem.A * c;
  for (int sweep = 0; sweep < 10000; ++sweep) {
    if (problem.poll) problem.poll();
    double largest = 0.0;
    for (Index j = 0; j < problem.num_terms(); ++j) {
      if (problem.column_norm(j) == 0.0) continue;
      const double pull = c(j) + problem.A.col(j).dot(residual);
      const double next = std::copysign(std::max(0.0, std::abs(pull) - penalty), pull);
      const double change = next - c(j);
      if (change != 0.0) residual -= change * problem.A.col(j);
      c(j) = next;
      largest = std::max(largest, std::abs(change));
    }
    if (largest < 1e-10) return true;
  }
  return false;
}

std::vector<Index> support(const VectorXd& c) {
  std::vector<Index> kept;
  for (Index j = 0; j < c.size(); ++j)
    if (c(j) != 0.0) kept.push_back(j);
  return kept;
}

// Falling fractions of the largest useful penalty: the whole path, or as far as the one asked for.
std::vector<double> path_of(const LassoOptions& options) {
  std::vector<double> fractions;
  for (int i = 1; i < options.path_length; ++i)
    fractions.push_back(std::pow(options.path_end, i / (options.path_length - 1.0)));
  if (options.lambda < 0.0) return fractions;
  std::erase_if(fractions, [&](double fraction) { return fraction <= options.lambda; });
  fractions.push_back(options.lambda);
  return fractions;
}

// What entered and what left between two supports.
void record(const std::vector<Index>& before, const std::vector<Index>& now, double fraction, double noise_variance,
            Fit& fit) {
  for (const Index term : before)
    if (!std::binary_search(now.begin(), now.end(), term))
      fit.steps.push_back({FitAction::remove, term, nan, noise_variance, -1, {}, fraction});
  for (const Index term : now)
    if (!std::binary_search(before.begin(), before.end(), term))
      fit.steps.push_back({FitAction::add, term, nan, noise_variance, -1, {}, fraction});
}

}  // namespace

Fit fit_lasso(const RFactor& data, const LassoOptions& options) {
  if (options.path_length < 2 || !(options.path_end > 0.0 && options.path_end < 1.0))
    throw std::invalid_argument("fit_lasso: path_length must be at least 2 and path_end in (0, 1)");
  const UnitProblem problem = one_target(data, "fit_lasso", options.poll);
  Fit fit;
  fit.method = Method::lasso;
  if (cannot_begin(problem, fit)) return fit;

  const double largest = (problem.A.transpose() * problem.Y.col(0)).cwiseAbs().maxCoeff();
  const auto m = static_cast<double>(problem.num_samples);
  // Of supports that fit exactly the smallest is best, whatever rounding leaves of their residuals.
  const double floor = 1e-26 / m;
  UnitProblem at_unit_norm = problem;  // its variances neither overflow nor vanish
  at_unit_norm.target_norm(0) = 1.0;
  VectorXd c = VectorXd::Zero(problem.num_terms());
  std::vector<Index> before, best;
  fit.steps.push_back(start_from({}));
  fit.steps.back().noise_variance = problem.target_norm(0) * problem.target_norm(0) / m;
  std::size_t steps_to_best = 1;
  double best_bic = std::numeric_limits<double>::infinity();
  for (const double fraction : path_of(options)) {
    const bool settled = coordinate_descent(problem, fraction * largest, c);
    ++fit.iterations;
    std::vector<Index> kept = support(c);
    const bool asked_for = fraction == options.lambda;
    if (!asked_for && (kept == before || static_cast<Index>(kept.size()) >= problem.num_samples)) continue;
    Fit at;
    finish_least_squares(at_unit_norm, kept, 0.0, at);
    record(before, kept, fraction, at.noise_variance * problem.target_norm(0) * problem.target_norm(0), fit);
    const double bic =
        m * std::log(std::max(floor, at.noise_variance)) + static_cast<double>(at.relevant.size()) * std::log(m);
    before = kept;
    if (!asked_for && (options.lambda >= 0.0 || !(bic < best_bic))) continue;
    best_bic = bic;
    best = std::move(kept);
    steps_to_best = fit.steps.size();
    fit.status = settled ? FitStatus::converged : FitStatus::iteration_limit;
  }
  fit.steps.erase(fit.steps.begin() + static_cast<std::ptrdiff_t>(steps_to_best), fit.steps.end());
  finish_least_squares(problem, std::move(best), 0.0, fit);
  for (std::size_t i = steps_to_best; i < fit.steps.size(); ++i) fit.steps[i].noise_variance = fit.noise_variance;
  return fit;
}

MethodDescription describe(const LassoOptions& /*options*/) {
  return row<LassoOptions, fit_lasso>(
      Method::lasso, "lasso", "least squares with a penalty on |c|; what it keeps is fitted again without",
      {setting<&LassoOptions::lambda>(
          {.name = "lasso_lambda",
           .help = "Penalty of lasso, a fraction of the largest useful one; by BIC if left out"})});
}

}  // namespace ident
