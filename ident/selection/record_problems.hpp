#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/regression/posterior.hpp"

namespace ident {

/// Regressions of one target on the same candidates, one for each of several records whose coefficients are their own.
/// What some terms leave is the sum over the records, as a fraction of all the targets' squares.
struct RecordProblems {
  std::vector<UnitProblem> records;  ///< at least one
  Eigen::VectorXd weight;            ///< of each record in such sums: its target's squares, as a fraction of all

  RecordProblems(UnitProblem one);  // NOLINT(google-explicit-constructor): one record is the usual case
  /// Of R factors with one target in one unit. Throws std::invalid_argument for none, and for other shapes.
  explicit RecordProblems(const std::vector<RFactor>& factors, const Poll& poll = {});
  [[nodiscard]] Eigen::Index num_terms() const { return records.front().num_terms(); }
  [[nodiscard]] Eigen::Index num_samples() const;  ///< of all records
  [[nodiscard]] double num_records() const { return static_cast<double>(records.size()); }
};

/// What least squares leaves where the coefficients of `common` terms are one for all records and those of `differing`
/// terms are each record's own: as a fraction of all the targets' squares.
[[nodiscard]] double shared_rss(const RecordProblems& problems, const std::vector<Eigen::Index>& common,
                                const std::vector<Eigen::Index>& differing);

}  // namespace ident
