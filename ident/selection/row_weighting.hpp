#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "ident/regression/r_factor.hpp"

namespace ident {

/// Rows of one record among those of a range: [first, last).
struct RecordRows {
  Eigen::Index first = 0, last = 0;
  std::size_t recording = 0;  ///< 0-based
};

/// What makes the noise of rows white and the same in all records: whitening by an autoregression of order one, and a
/// factor for each record.
struct RowWeighting {
  std::vector<unsigned char> begins;  ///< of runs of consecutive rows
  std::vector<RecordRows> records;    ///< in the order of the rows
  double rho = 0.0;                   ///< 0: they are not whitened
  std::vector<double> weight = {};    ///< rows of each record are multiplied by it; empty: none is
  [[nodiscard]] bool changes_rows() const { return rho != 0.0 || !weight.empty(); }
  /// The largest of the weights.
  [[nodiscard]] double largest_weight() const;
  [[nodiscard]] Eigen::VectorXd weighted(Eigen::VectorXd values) const;
  /// The rows that `read` gives; this must outlive the result.
  [[nodiscard]] RowReader weighted(RowReader read) const;
};

}  // namespace ident
