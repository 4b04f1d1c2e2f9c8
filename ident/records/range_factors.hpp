#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/regression/r_factor.hpp"
#include "ident/selection/effective_size.hpp"

namespace ident {

/// Consecutive training rows of one recording, as the columns are.
struct FactorBlock {
  double from_s = 0.0, to_s = 0.0;  ///< of the first row's sample, behind the last one's
  double target_sum = 0.0;          ///< of its rows: errors are about the mean
  RFactor data;
};

/// The training rows of a range as R factors: all that a fit of several records together needs of each. Of b terms that
/// the rows can tell apart and the target.
struct RangeFactors {
  std::vector<Eigen::Index> terms;  ///< of the library
  Eigen::VectorXd scale;            ///< largest magnitude of each of them
  RFactor white;                    ///< what the sensors leave of the rows; each counts in full
  RFactor evidence;                 ///< the same whitened and weighted down to their effective number (num_samples), as
                                    ///< Selection::evidence takes them; of no terms where no method asked for it
  EffectiveSize size;               ///< by which they are
  std::vector<FactorBlock> blocks;  ///< in the order of recordings and time; together all training rows
};

/// At most `most` blocks of about as many rows in the order of time, one at least for each recording.
[[nodiscard]] std::vector<FactorBlock> factor_blocks(const std::vector<Row>& rows,
                                                     const std::vector<Columns>& recordings,
                                                     const std::vector<Eigen::Index>& terms, Eigen::Index most,
                                                     const std::function<void()>& poll = {});

}  // namespace ident
