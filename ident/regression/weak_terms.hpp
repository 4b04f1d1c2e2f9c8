#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/regression/posterior.hpp"

namespace ident {

/// Covariance of the kept coefficients (b' x b', at unit norm) where a term that gained too little to be kept may be
/// there all the same: left out, its part of the target goes to its neighbours. It is that of a mixture: the kept terms
/// alone, and with one or two more at their least-squares coefficients, weighted by Akaike's criterion and by prior
/// odds that expect one weak term of the first degree among those left out, and fewer of higher ones (degrees that are
/// not known count as the first). The standard deviations are 1/1.96 of the half widths about the kept coefficients
/// that hold 95 % of the mixture: a few improbable models with wide posteriors would make its variance larger than an
/// interval needs.
/// A kept term whose gain is little above `tau` may be none all the same: with the probability of that its coefficient
/// is zero and its part of the target goes to the others. That is added as a variance. Without it a weak term, kept
/// only where noise makes it large, is hardly ever covered. `lambda` and `noise_variance` are those of the kept terms
/// alone.
[[nodiscard]] Eigen::MatrixXd covariance_with_weak_terms(const UnitProblem& problem,
                                                         const std::vector<Eigen::Index>& kept,
                                                         const Eigen::VectorXd& lambda, double noise_variance,
                                                         double tau);

}  // namespace ident
