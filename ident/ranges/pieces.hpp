#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "ident/columns/columns.hpp"
#include "ident/ranges/ranges.hpp"

namespace ident {

/// Samples [first, last) of a recording at the rate of its intermediate signals.
struct Piece {
  std::size_t recording;
  Eigen::Index first, last;
  [[nodiscard]] Eigen::Index size() const { return last - first; }
};

/// Rows as they were recorded, and where they begin or end with the record, the rest of it: what filters spoil there is
/// not spoilt. `are_last`: of the range, no others come behind them; `with_gaps`: samples between them are missing ones
/// of one piece. None of fewer than 32 samples, which say nothing but where they begin.
[[nodiscard]] std::vector<Piece> pieces_of(const Range& range, const std::vector<Row>& rows, bool are_last,
                                           const std::vector<Columns>& recordings, bool with_gaps);

[[nodiscard]] Eigen::Index num_samples(const std::vector<Piece>& pieces);

/// So much of each, up to eight parts spread over it, that all together are not more than `most`; none of fewer than
/// 512 samples where the piece has as many.
[[nodiscard]] std::vector<Piece> shortened(const std::vector<Piece>& pieces, Eigen::Index most);

}  // namespace ident
