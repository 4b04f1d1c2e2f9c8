#include <cmath>
#include <stdexcept>

#include "ident/finish_fit.hpp"
#include "ident/fit.hpp"

namespace ident {

Fit fit_stlsq(const RFactor& data, const StlsqOptions& options) {
  if (!(options.threshold >= 0.0)) throw std::invalid_argument("fit_stlsq: threshold must not be negative");
  const UnitProblem problem = unit_problem(data);
  Fit fit;
  fit.method = Method::stlsq;
  if (cannot_begin(problem, fit)) return fit;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < problem.num_terms(); ++i)
    if (problem.column_norm(i) > 0.0) kept.push_back(i);
  fit.status = FitStatus::iteration_limit;
  while (fit.iterations++ < options.max_iterations) {
    Fit step;
    finish_least_squares(problem, kept, 0.0, step);
    std::vector<Eigen::Index> next;
    for (std::size_t j = 0; j < kept.size(); ++j) {
      const double size = std::abs(step.mean(static_cast<Eigen::Index>(j))) *
                          (options.unit_norm ? problem.column_norm(kept[j]) / problem.target_norm : 1.0);
      if (size >= options.threshold)
        next.push_back(kept[j]);
      else
        fit.steps.push_back({FitAction::remove, kept[j], fit.log_evidence, step.noise_variance});
    }
    const bool settled = next.size() == kept.size();
    kept = std::move(next);
    if (settled || kept.empty()) {
      fit.status = FitStatus::converged;
      break;
    }
  }
  finish_least_squares(problem, kept, 0.0, fit);
  return fit;
}

}  // namespace ident
