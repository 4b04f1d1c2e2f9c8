#pragma once
#include <stdexcept>
#include <string>

#include "ident/regression/fit.hpp"
#include "ident/regression/posterior.hpp"

namespace ident {

/// The regression of the only target. Throws std::invalid_argument, in the name of `function`, if there are several.
[[nodiscard]] UnitProblem one_target(const RFactor& data, const char* function, Poll poll);

/// A fit that could not begin: no rows, zero target. True if `fit.status` was set.
[[nodiscard]] bool cannot_begin(const UnitProblem& problem, Fit& fit);
/// The same for a relevance vector machine, whose method, selection and tau it fills in. Throws std::invalid_argument
/// for an initial noise outside (0, 1).
template <Method method>
[[nodiscard]] bool cannot_begin(const UnitProblem& problem, const RvmOptions<method>& options, Fit& fit) {
  if (!(options.initial_noise_fraction > 0.0 && options.initial_noise_fraction < 1.0))
    throw std::invalid_argument("fit_" + std::string(to_string(method)) + ": initial_noise_fraction must be in (0, 1)");
  fit.method = method;
  fit.selection = options.selection;
  if (cannot_begin(problem, fit)) return true;
  fit.tau = gain_threshold(options.selection, options.tau, problem.num_samples, problem.num_terms());
  return false;
}

/// Fills mean, covariance, alpha, noise, evidence, gains and condition number of a Bayesian fit from its end point and
/// returns them to the caller's units. `kept` and `lambda` belong together; kept need not be ascending.
void finish_bayesian(const UnitProblem& problem, std::vector<Eigen::Index> kept, Eigen::VectorXd lambda,
                     double noise_variance, Fit& fit);

/// A Bayesian fit on these terms and no search, under flat priors: a term near its own error is not shrunk for having
/// been kept. Fills in what finish_bayesian does; fit.method, selection and tau are the caller's.
void fit_on_terms(const UnitProblem& problem, const std::vector<Eigen::Index>& terms, Fit& fit);

/// The columns that are not zero throughout.
[[nodiscard]] std::vector<Eigen::Index> usable_terms(const UnitProblem& problem);

/// The first step of a fit that has not been solved yet.
[[nodiscard]] FitStep start_from(std::vector<Eigen::Index> kept);

/// Least squares on `kept` by QR of unit-norm columns; fills mean, covariance, noise and condition number. Of columns
/// that depend on one another the later are left out, listed in `fit.dependent` and as steps; status rank_deficient.
/// Without a row to spare noise and covariance are NaN, status too_few_rows. `penalty` (ridge) is added to the
/// unit-norm normal matrix as rows sqrt(penalty), which keeps all columns and the status.
void finish_least_squares(const UnitProblem& problem, std::vector<Eigen::Index> kept, double penalty, Fit& fit);

/// Largest over smallest singular value of these unit-norm columns; infinite if one is zero.
[[nodiscard]] double condition_number(const UnitProblem& problem, const std::vector<Eigen::Index>& kept);

/// Largest variance inflation 1 / (1 - R^2) of any usable column on all others (no mean removed); 1 without columns.
[[nodiscard]] double largest_inflation(const UnitProblem& problem);

}  // namespace ident
