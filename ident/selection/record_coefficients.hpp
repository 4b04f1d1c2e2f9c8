#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/selection/best_subsets.hpp"
#include "ident/selection/effective_size.hpp"

namespace ident {

/// The terms of an equation of several records, and which of them have a coefficient for each record.
struct RecordCoefficients {
  std::vector<Eigen::Index> terms;      ///< ascending
  std::vector<Eigen::Index> differing;  ///< of these, ascending; the others' coefficients are the same in all records
  [[nodiscard]] std::vector<Eigen::Index> common() const;
  [[nodiscard]] bool operator==(const RecordCoefficients&) const = default;
};

/// As which a term must earn its place to be more than an error of the model: min(n_a, n_s) where n_eff is less than
/// half of the rows, n_eff where noise is what limits them.
[[nodiscard]] double effective_rows_for_terms(const EffectiveSize& size);

/// Which coefficients of these terms (one at least) differ between the records: of all choices on the way from every
/// one to none, each step making common what costs least, that of the least
///     n ln rss + d ((R - 1) ln n + 2 ln k),
/// twice the negative log probability of d of k terms differing, each with odds of one to k beforehand (as a candidate
/// belongs with one to b, gain_threshold).
/// Then candidates that were not worth a coefficient in each record are tried with a common one, whose gain must exceed
/// ln n + 2 ln b as that of any single term (gain_threshold), with n the size at which it is more than an error of the
/// model; after each the first question is asked again, because a weak common term left out makes its neighbours
/// differ. `size`: of the rows of all records.
///
/// The records are as of select_size, which finds `terms`: in units in which their noise is the same.
[[nodiscard]] RecordCoefficients record_coefficients(const RecordProblems& problems,
                                                     const std::vector<Eigen::Index>& terms, const EffectiveSize& size);

}  // namespace ident
