#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "ident/finish_fit.hpp"
#include "ident/fit.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Minimises ||y - A c||^2 / 2 + penalty ||c||_1 for unit-norm columns, from `c`; keeps the residual up to date.
void coordinate_descent(const UnitProblem& problem, double penalty, VectorXd& c) {
  VectorXd residual = problem.y - problem.A * c;
  for (int sweep = 0; sweep < 10000; ++sweep) {
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
    if (largest < 1e-10) return;
  }
}

std::vector<Index> support(const VectorXd& c) {
  std::vector<Index> kept;
  for (Index j = 0; j < c.size(); ++j)
    if (c(j) != 0.0) kept.push_back(j);
  return kept;
}

}  // namespace

Fit fit_lasso(const RFactor& data, const LassoOptions& options) {
  if (options.path_length < 2 || !(options.path_end > 0.0 && options.path_end < 1.0))
    throw std::invalid_argument("fit_lasso: path_length must be at least 2 and path_end in (0, 1)");
  const UnitProblem problem = unit_problem(data);
  Fit fit;
  fit.method = Method::lasso;
  if (cannot_begin(problem, fit)) return fit;

  const double largest = (problem.A.transpose() * problem.y).cwiseAbs().maxCoeff();
  const auto m = static_cast<double>(problem.num_samples);
  VectorXd c = VectorXd::Zero(problem.num_terms());
  std::vector<Index> best;
  if (options.lambda >= 0.0) {
    coordinate_descent(problem, options.lambda * largest, c);
    best = support(c);
    fit.iterations = 1;
  } else {
    double best_bic = std::numeric_limits<double>::infinity();
    std::vector<Index> before;
    for (int i = 1; i < options.path_length; ++i) {
      coordinate_descent(problem, largest * std::pow(options.path_end, i / (options.path_length - 1.0)), c);
      std::vector<Index> kept = support(c);
      ++fit.iterations;
      if (kept.empty() || kept == before) continue;
      for (const Index term : kept)
        if (std::find(before.begin(), before.end(), term) == before.end())
          fit.steps.push_back({FitAction::add, term, std::numeric_limits<double>::quiet_NaN(), 0.0});
      before = kept;
      Fit at;
      finish_least_squares(problem, kept, 0.0, at);
      const double bic = m * std::log(at.noise_variance) + static_cast<double>(kept.size()) * std::log(m);
      if (bic < best_bic) best_bic = bic, best = std::move(kept);
    }
  }
  finish_least_squares(problem, best, 0.0, fit);
  return fit;
}

}  // namespace ident
