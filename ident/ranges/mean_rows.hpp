#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "ident/ranges/ranges.hpp"

namespace ident {

class RangeSensors;

/// One row [Psi Phi t] for each recording with such means: those of sensors, terms and target over the training rows,
/// ahead of the column filter, times the square root of the number of rows. Its noise is that of any other row.
/// Over a long record the mean acceleration is close to zero, which determines the zero of x; nothing that passes a
/// high-pass does, behind which a zero that is off looks like x^2.
struct MeanRows {
  Eigen::MatrixXd rows;
  std::vector<std::size_t> recordings;  ///< of each row, 0-based
};
/// `terms`: of the library; sensors' columns are formed. A recording less than half of whose rows fill whole blocks has
/// no row.
[[nodiscard]] MeanRows mean_rows(const std::vector<Row>& rows, const std::vector<Columns>& recordings,
                                 const std::vector<Eigen::Index>& terms, const RangeSensors& sensors);

}  // namespace ident
