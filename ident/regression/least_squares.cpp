#include <stdexcept>

#include "ident/regression/describe.hpp"
#include "ident/regression/finish_fit.hpp"
#include "ident/regression/fit.hpp"

namespace ident {
namespace {

Fit least_squares(const RFactor& data, const std::vector<Eigen::Index>& terms, double penalty, Method method,
                  const Poll& poll) {
  const UnitProblem problem = one_target(data, method == Method::ols ? "fit_ols" : "fit_ridge", poll);
  Fit fit;
  fit.method = method;
  if (cannot_begin(problem, fit)) return fit;
  std::vector<Eigen::Index> kept;
  for (const Eigen::Index term : terms) {
    if (term < 0 || term >= problem.num_terms()) throw std::invalid_argument("fit_ols: no such term");
    if (problem.column_norm(term) > 0.0) kept.push_back(term);
  }
  if (penalty == 0.0 && problem.num_samples < static_cast<Eigen::Index>(kept.size())) {
    fit.status = FitStatus::too_few_rows;
    return fit;
  }
  fit.steps.push_back(start_from(kept));
  finish_least_squares(problem, std::move(kept), penalty, fit);
  for (FitStep& step : fit.steps) step.noise_variance = fit.noise_variance;
  return fit;
}

}  // namespace

Fit fit_ols(const RFactor& data, const OlsOptions& options) {
  return least_squares(data, all_columns(data.num_terms), 0.0, Method::ols, options.poll);
}

Fit fit_ols(const RFactor& data, const std::vector<Eigen::Index>& terms) {
  return least_squares(data, terms, 0.0, Method::ols, {});
}

Fit fit_ridge(const RFactor& data, const RidgeOptions& options) {
  if (!(options.lambda > 0.0)) throw std::invalid_argument("fit_ridge: lambda must be positive");
  return least_squares(data, all_columns(data.num_terms), options.lambda, Method::ridge, options.poll);
}

MethodDescription describe(const RidgeOptions& /*options*/) {
  return row<RidgeOptions, fit_ridge>(
      Method::ridge, "ridge", "least squares with a penalty on c^2; keeps all terms",
      {setting<&RidgeOptions::lambda>(
          {.name = "ridge_lambda", .help = "Penalty of ridge, on columns of unit norm", .may_be_zero = false})});
}

MethodDescription describe(const OlsOptions& /*options*/) {
  return row<OlsOptions, fit_ols>(Method::ols, "ols", "least squares on all terms", {});
}

}  // namespace ident
