#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/selection/record_problems.hpp"

namespace ident {

/// Terms, and what least squares on them leaves of a target of unit norm, with coefficients of each record.
struct Subset {
  std::vector<Eigen::Index> terms;  ///< ascending
  double rss = 1.0;
};

/// For each number of terms from none to `largest` (fewer where no more are independent) those that leave least of the
/// only target: by forward selection and backward elimination, each size improved by exchanges of one term.
[[nodiscard]] std::vector<Subset> best_subsets(const RecordProblems& problems, Eigen::Index largest);

/// What least squares on these terms leaves.
[[nodiscard]] double least_squares_rss(const RecordProblems& problems, const std::vector<Eigen::Index>& terms);

/// What k of b terms cost in twice the log evidence: ln n for each of their values, of which a term has as many as
/// `coefficients`, and for the choice of them, by what the residual is. Where it is misfit, a function of the state,
/// any number of terms is as likely beforehand as any other: 2 ln (b over k). Where it is noise, one term is expected:
/// 2 ln b each, as in the threshold of Selection::evidence. `structural_fraction`: what of it is misfit.
[[nodiscard]] double model_cost(double num_effective, Eigen::Index num_terms, std::size_t k, double coefficients = 1.0,
                                double structural_fraction = 1.0);

}  // namespace ident
