#pragma once
#include <Eigen/Core>
#include <vector>

#include "ident/columns.hpp"
#include "ident/ranges.hpp"
#include "ident/selection/record_problems.hpp"
#include "ident/selection/row_weighting.hpp"

namespace ident {

struct IdentifyOptions;
struct RangeData;
struct RangeResult;

/// The candidates and the target on the training rows of a range, without what the sensors add to it. What it is made
/// of must outlive it.
struct EvidenceRows {
  const RangeData& range;
  const RangeResult& result;
  const std::vector<Columns>& recordings;
  const IdentifyOptions& options;
  Eigen::VectorXd target;
  RowWeighting weighting;  ///< that makes them evidence

  EvidenceRows(const RangeData& its_range, const RangeResult& its_result, const std::vector<Columns>& its_recordings,
               const IdentifyOptions& its_options);
  [[nodiscard]] Eigen::Index size() const { return target.size(); }
  [[nodiscard]] Eigen::Index num_terms() const;
  [[nodiscard]] const std::vector<RecordRows>& records() const { return weighting.records; }
  /// Rows of [Phi t], as they are.
  [[nodiscard]] RowReader reader(const Eigen::VectorXd& its_target) const;
  /// Greatest magnitude in each of their columns.
  [[nodiscard]] Eigen::RowVectorXd largest(const Eigen::VectorXd& its_target) const;
  /// R of [front Phi t], `read_front` writing the first columns; weighted. Of all rows, or of one record.
  [[nodiscard]] RFactor factor(Eigen::Index num_front, const Eigen::RowVectorXd& largest_front,
                               const RowReader& read_front, const Eigen::VectorXd& its_target,
                               const RecordRows* record = nullptr) const;
  /// R of [Phi t] for each record.
  [[nodiscard]] std::vector<RFactor> factors() const;
  /// Of a term of the library, weighted.
  [[nodiscard]] Eigen::VectorXd column(Eigen::Index term) const;
  /// What least squares on these candidates leaves in each record, weighted.
  [[nodiscard]] Eigen::VectorXd residual(const RecordProblems& problems,
                                         const std::vector<Eigen::Index>& positions) const;
};

}  // namespace ident
