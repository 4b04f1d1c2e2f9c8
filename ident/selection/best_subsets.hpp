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

/// These terms, one at least, less the one without which least leaves.
[[nodiscard]] Subset without_weakest(const RecordProblems& problems, const std::vector<Eigen::Index>& terms);

/// What least squares on these terms leaves.
[[nodiscard]] double least_squares_rss(const RecordProblems& problems, const std::vector<Eigen::Index>& terms);

/// What k of b terms cost in twice the log evidence: ln n each for their values, and twice the log of how many such
/// models there are, so that each number of terms is as likely beforehand as any other. `coefficients` of each term
/// are as many values.
[[nodiscard]] double model_cost(double num_effective, Eigen::Index num_terms, std::size_t k, double coefficients = 1.0);

}  // namespace ident
