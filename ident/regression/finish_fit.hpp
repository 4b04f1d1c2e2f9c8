#pragma once
#include "ident/fit.hpp"
#include "ident/regression/posterior.hpp"

namespace ident {

/// A fit that could not begin: no rows, zero target. True if `fit.status` was set.
[[nodiscard]] bool cannot_begin(const UnitProblem& problem, Fit& fit);

/// Fills mean, covariance, alpha, noise, evidence, gains and condition number of a Bayesian fit from its end point and
/// returns them to the caller's units. `kept` and `lambda` belong together; kept need not be ascending.
void finish_bayesian(const UnitProblem& problem, std::vector<Eigen::Index> kept, Eigen::VectorXd lambda,
                     double noise_variance, Fit& fit);

/// The columns that are not zero throughout.
[[nodiscard]] std::vector<Eigen::Index> usable_terms(const UnitProblem& problem);

/// The first step of a fit that has not been solved yet.
[[nodiscard]] FitStep start_from(std::vector<Eigen::Index> kept);

/// Least squares on `kept` by QR of unit-norm columns; fills mean, covariance, noise and condition number. Of columns
/// that depend on one another the later are left out, told in `fit.dependent` and as steps; status rank_deficient.
/// Without a row to spare noise and covariance are NaN, status too_few_rows. `penalty` (ridge) is added to the
/// unit-norm normal matrix as rows sqrt(penalty), which keeps all columns and the status.
void finish_least_squares(const UnitProblem& problem, std::vector<Eigen::Index> kept, double penalty, Fit& fit);

/// Largest over smallest singular value of these unit-norm columns; infinite if one is zero.
[[nodiscard]] double condition_number(const UnitProblem& problem, const std::vector<Eigen::Index>& kept);

/// Largest variance inflation 1 / (1 - R^2) of any usable column on all others (no mean removed); 1 without columns.
[[nodiscard]] double largest_inflation(const UnitProblem& problem);
/// Beyond this inflation terms hide one another, and a search from the empty model alone can stop short; libraries
/// wider than this are not started from the full model.
inline constexpr double inflation_of_a_hard_library = 10.0;
inline constexpr Eigen::Index widest_full_start = 60;

}  // namespace ident
