#pragma once
#include <vector>

#include "ident/validate/free_run.hpp"

namespace ident {

/// The free runs of the equation that follows x most closely of those whose coefficients lie within the region that
/// holds 99 % of Model::covariance: whether what a free run misses is more than what is not known of the coefficients.
/// On test rows, and of an equation that nothing drives on training rows as well, the same coefficients on both.
struct ClosestRun {
  FreeRun test, training;  ///< without training rows the latter is that of no course
};

/// By Gauss and Newton's method from the coefficients of `model`, to a local minimum of the sum of both NMSE, or
/// to where it is below `enough` of the power of x about its mean; of an equation that nothing drives over runs of one
/// period first. Where no covariance is known, or `model` diverges or has no free run, that of `model` itself.
[[nodiscard]] ClosestRun closest_run(const Model& model, const std::vector<Course>& test,
                                     const std::vector<Course>& training, double enough, const FreeRunOptions& options);

}  // namespace ident
