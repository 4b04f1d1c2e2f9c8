#pragma once
#include <string>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/equation/verdict.hpp"
#include "ident/ranges/ranges.hpp"
#include "ident/state_space/problem.hpp"

namespace ident {

struct RangeData;

/// The likelihood of the samples of rows as they were recorded, stated: one body, its channels of x, v or a, and
/// inputs; terms in the order of the candidates, then what is none and may be missing.
struct Statement {
  state_space::Problem problem;
  std::vector<Explanation> outside = {};  ///< usual forms and signals that act from outside
  std::string obstacle = {};              ///< not empty: why there is no problem
  double thinned_by = 1.0;                ///< recorded samples a sample
};

/// `are_last`: of the range, no others come behind them.
[[nodiscard]] Statement statement_of(const Range& range, const std::vector<Row>& rows, bool are_last,
                                     const RangeData& data, const std::vector<Columns>& recordings);

}  // namespace ident
