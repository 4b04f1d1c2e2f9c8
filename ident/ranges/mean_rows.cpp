#include "ident/ranges/mean_rows.hpp"

#include <algorithm>
#include <cmath>

#include "ident/columns/columns.hpp"
#include "ident/ranges/range_sensors.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Blocks whose every row is among those fitted, and how many rows these are.
struct WholeBlocks {
  std::vector<Index> blocks;
  Index num_rows = 0, num_all = 0;  ///< of the recording: in these blocks, and fitted

  WholeBlocks(const std::vector<Row>& rows, std::size_t recording, const Columns& columns) {
    const dsp::Motion& signals = *columns.signals;
    const double ratio = columns.prepared->intermediate.sample_rate_hz / signals.sample_rate_hz;
    const auto block_of = [&](Index sample) {
      return static_cast<Index>(std::floor((static_cast<double>(sample) * ratio + 0.5))) / columns.means.size;
    };
    std::vector<Index> fitted(static_cast<std::size_t>(columns.means.values.rows()), 0), all = fitted;
    for (Index i = 0; i < signals.num_samples(); ++i)
      if (const auto block = static_cast<std::size_t>(block_of(i)); block < all.size()) ++all[block];
    for (const Row& row : rows) {
      if (row.recording != recording) continue;
      ++num_all;
      if (const auto block = static_cast<std::size_t>(block_of(row.sample)); block < all.size()) ++fitted[block];
    }
    for (std::size_t block = 0; block < all.size(); ++block)
      if (fitted[block] > 0 && fitted[block] == all[block]) {
        blocks.push_back(static_cast<Index>(block));
        num_rows += all[block];
      }
  }
};

}  // namespace

MeanRows mean_rows(const std::vector<Row>& rows, const std::vector<Columns>& recordings,
                   const std::vector<Index>& terms, const RangeSensors& sensors) {
  const auto n_s = std::ssize(sensors.parameters()), b = std::ssize(terms);
  const std::vector<TermColumn>& known = recordings.front().term_columns;
  MeanRows result{MatrixXd(0, n_s + b + 1), {}};
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const BlockMeans& means = recordings[r].means;
    if (means.size == 0) continue;
    const WholeBlocks whole(rows, r, recordings[r]);
    if (whole.num_rows == 0 || 2 * whole.num_rows < whole.num_all) continue;
    Eigen::RowVectorXd mean(n_s + b + 1);
    mean.head(n_s) = sensors.mean(r, whole.blocks);
    const auto mean_of = [&](Index column) { return means.values(whole.blocks, column).mean(); };
    for (Index j = 0; j < b; ++j) {
      const Index term = terms[static_cast<std::size_t>(j)];
      const TermColumn column = known.empty() ? TermColumn{term} : known[static_cast<std::size_t>(term)];
      const bool is_elsewhere = column.recording > 0 && static_cast<std::size_t>(column.recording) != r + 1;
      mean(n_s + j) = is_elsewhere ? 0.0 : mean_of(column.column);
    }
    mean(n_s + b) = mean_of(means.values.cols() - 1);
    if (!mean.allFinite()) continue;
    result.rows.conservativeResize(result.rows.rows() + 1, Eigen::NoChange);
    result.rows.bottomRows(1) = std::sqrt(static_cast<double>(whole.num_rows)) * mean;
    result.recordings.push_back(r);
  }
  return result;
}

}  // namespace ident
