#pragma once
#include <vector>

#include "ident/regression/fit.hpp"
#include "ident/regression/posterior.hpp"

namespace ident {

/// Libraries up to this wide have all their models scored.
inline constexpr Eigen::Index widest_ranked_library = 20;

/// Models of the only target, by least squares and the score of Selection::evidence: with n rows, twice the negative
/// log probability is n ln rss + model_cost(n, b, k), but for what all share. That ranks them. Whether a term is there
/// is asked otherwise: one that is in question is not as large as the target, it is of a few standard errors;
/// `inclusion` is the sum over the same models at model_cost(min(n, 400), b, k), the cost of coefficients of 20
/// standard errors.
///
/// Up to widest_ranked_library terms every subset is scored. Beyond, every subset of as many terms as that: the weaker
/// half of them kept ones, the others those left out which would do most; the inclusion of all others is 1 where they
/// are kept, and not a number where not. Models with less than two rows to spare are not scored. `kept`: ascending.
[[nodiscard]] ModelRanking ranked_models(const UnitProblem& problem, const std::vector<Eigen::Index>& kept);

}  // namespace ident
