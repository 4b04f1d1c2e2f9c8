#include <cmath>
#include <stdexcept>

#include "dsp/values/constants.hpp"
#include "ident/regression/describe.hpp"
#include "ident/regression/finish_fit.hpp"
#include "ident/regression/fit.hpp"

namespace ident {
namespace {

using Eigen::Index;

std::vector<Index> below_threshold(const UnitProblem& problem, const StlsqOptions& options, const Fit& fit) {
  std::vector<Index> small;
  for (std::size_t j = 0; j < fit.relevant.size(); ++j) {
    const double scale = options.unit_norm ? problem.column_norm(fit.relevant[j]) / problem.target_norm(0) : 1.0;
    if (!(std::abs(fit.mean(static_cast<Index>(j))) * scale >= options.threshold)) small.push_back(fit.relevant[j]);
  }
  return small;
}

}  // namespace

Fit fit_stlsq(const RFactor& data, const StlsqOptions& options) {
  if (!(options.threshold >= 0.0)) throw std::invalid_argument("fit_stlsq: threshold must not be negative");
  const UnitProblem problem = one_target(data, "fit_stlsq", options.poll);
  Fit fit;
  fit.method = Method::stlsq;
  if (cannot_begin(problem, fit)) return fit;
  std::vector<Index> kept = usable_terms(problem);
  if (problem.num_samples < static_cast<Index>(kept.size())) {
    fit.status = FitStatus::too_few_rows;
    return fit;
  }
  fit.steps.push_back(start_from(kept));
  for (std::size_t solved = 0;;) {
    ++fit.iterations;
    finish_least_squares(problem, kept, 0.0, fit);
    for (; solved < fit.steps.size(); ++solved) fit.steps[solved].noise_variance = fit.noise_variance;
    const std::vector<Index> small = below_threshold(problem, options, fit);
    if (small.empty()) break;
    if (fit.iterations >= options.max_iterations) {
      fit.status = FitStatus::iteration_limit;
      break;
    }
    kept.clear();
    for (std::size_t i = 0, next = 0; i < fit.relevant.size(); ++i) {
      if (next == small.size() || fit.relevant[i] != small[next]) {
        kept.push_back(fit.relevant[i]);
        continue;
      }
      fit.steps.push_back({FitAction::remove, small[next++], dsp::nan, dsp::nan});
    }
  }
  return fit;
}

MethodDescription describe(const StlsqOptions& /*options*/) {
  return row<StlsqOptions, fit_stlsq>(
      Method::stlsq, "sindy", "least squares, small coefficients cut, and again (STLSQ)",
      {setting<&StlsqOptions::threshold>({.name = "threshold",
                                          .help = "Coefficients below it are cut by sindy",
                                          .study_values = {"0.005", "0.01", "0.02", "0.05", "0.1"}}),
       setting<&StlsqOptions::unit_norm>({.name = "threshold_on",
                                          .help = "What the threshold is compared with: |c| as it is (raw), or times "
                                                  "its column's norm over the target's",
                                          .words = {"raw", "unit-norm"}})});
}

}  // namespace ident
