#include "ident/records/range_factors.hpp"

#include <algorithm>

#include "ident/ranges/rows_of_terms.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Of rows [first, last), which are of one recording.
FactorBlock block_of(const std::vector<Row>& rows, const std::vector<Columns>& recordings,
                     const std::vector<Index>& terms, std::size_t first, std::size_t last,
                     const std::function<void()>& poll) {
  const std::vector<Row> own(rows.begin() + static_cast<std::ptrdiff_t>(first),
                             rows.begin() + static_cast<std::ptrdiff_t>(last));
  const Columns& recording = recordings[own.front().recording];
  const RowsOfTerms columns(own, recordings, terms);
  FactorBlock block;
  const double rate_hz = recording.signals->sample_rate_hz;
  block.from_s = static_cast<double>(own.front().sample) / rate_hz;
  block.to_s = static_cast<double>(own.back().sample + 1) / rate_hz;
  const auto read = [&](Index from, Eigen::Ref<MatrixXd> into) {
    if (poll) poll();
    columns.read(from, into.leftCols(columns.num_terms()));
    for (Index i = 0; i < into.rows(); ++i)
      into(i, columns.num_terms()) = recording.target(own[static_cast<std::size_t>(from + i)].sample);
  };
  Eigen::RowVectorXd largest = Eigen::RowVectorXd::Zero(columns.num_terms() + 1);
  constexpr Index at_once = 1024;
  for (Index from = 0; from < columns.size(); from += at_once) {
    MatrixXd values(std::min(at_once, columns.size() - from), columns.num_terms() + 1);
    read(from, values);
    largest = largest.cwiseMax(values.cwiseAbs().colwise().maxCoeff());
    block.target_sum += values.rightCols(1).sum();
  }
  block.data = r_factor(columns.size(), columns.num_terms(), largest, read);
  return block;
}

}  // namespace

std::vector<FactorBlock> factor_blocks(const std::vector<Row>& rows, const std::vector<Columns>& recordings,
                                       const std::vector<Index>& terms, Index most, const std::function<void()>& poll) {
  std::vector<FactorBlock> blocks;
  const std::size_t each = std::max<std::size_t>(
      1, (rows.size() + static_cast<std::size_t>(most) - 1) / static_cast<std::size_t>(std::max<Index>(1, most)));
  for (std::size_t first = 0; first < rows.size();) {
    std::size_t last = first;
    while (last < rows.size() && last - first < each && rows[last].recording == rows[first].recording) ++last;
    blocks.push_back(block_of(rows, recordings, terms, first, last, poll));
    first = last;
  }
  return blocks;
}

}  // namespace ident
