#include "ident/regression/r_factor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "dsp/values/for_each_index.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Rows folded at once: enough for a reflector to be worth its square root, few enough to stay in cache.
constexpr Index rows_a_block = 256;
// Rows of one shard, the unit handed to a thread.
constexpr Index shard_rows = 128 * rows_a_block;
int threads_for(Index num_rows, int num_threads) {
  constexpr Index fewest = 100'000;  // less are folded sooner than a thread begins
  return num_rows < fewest ? 1 : num_threads;
}

// Powers of two that bring the greatest magnitude of each column to between 1 and 2, so that no square overflows or
// vanishes: to multiply by and to divide by is exact.
struct ColumnScale {
  Eigen::RowVectorXd down, up;
  explicit ColumnScale(const Eigen::RowVectorXd& largest) : down(largest.size()), up(largest.size()) {
    constexpr int least = std::numeric_limits<double>::min_exponent;  // whose inverse is still a number
    for (Index j = 0; j < largest.size(); ++j) {
      const bool usable = largest(j) > 0.0 && std::isfinite(largest(j));
      const int exponent = usable ? std::max(least, std::ilogb(largest(j))) : 0;
      down(j) = std::ldexp(1.0, -exponent);
      up(j) = std::ldexp(1.0, exponent);
    }
  }
};

Eigen::RowVectorXd largest_of(const Eigen::Ref<const MatrixXd>& columns) {
  if (columns.rows() == 0) return Eigen::RowVectorXd::Zero(columns.cols());
  return columns.cwiseAbs().colwise().maxCoeff();
}

// Of [R; rows].
MatrixXd folded(MatrixXd R, const Eigen::Ref<const MatrixXd>& rows) {
  const ColumnScale scale(largest_of(R).cwiseMax(largest_of(rows)));
  RowBlock block(rows.rows(), rows.cols());
  block.rows(0, rows.rows()) = rows;
  R.array().rowwise() *= scale.down.array();
  if (!block.scale(rows.rows(), scale.down)) R.setConstant(std::numeric_limits<double>::quiet_NaN());
  block.fold_into(R, rows.rows());
  R.array().rowwise() *= scale.up.array();
  return R;
}

}  // namespace

std::vector<Index> all_columns(Index count) {
  std::vector<Index> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), Index{0});
  return all;
}

MatrixXd triangle(const Eigen::Ref<const MatrixXd>& rows) {
  return folded(MatrixXd::Zero(rows.cols(), rows.cols()), rows);
}

RFactorBuilder::RFactorBuilder(Index num_terms, Index num_targets)
    : num_terms_(num_terms),
      num_targets_(num_targets),
      block_(rows_a_block, num_terms + num_targets),
      R_(MatrixXd::Zero(num_terms + num_targets, num_terms + num_targets)) {
  if (num_terms < 0 || num_targets < 1)
    throw std::invalid_argument("RFactorBuilder: needs terms >= 0 and targets >= 1");
}

void RFactorBuilder::push(const Eigen::Ref<const MatrixXd>& rows) {
  if (rows.cols() != R_.cols()) throw std::invalid_argument("RFactorBuilder::push: rows have another width");
  for (Index done = 0; done < rows.rows();) {
    const Index count = std::min(rows_a_block - filled_, rows.rows() - done);
    block_.rows(filled_, count) = rows.middleRows(done, count);
    filled_ += count;
    done += count;
    if (filled_ == rows_a_block) {
      block_.fold_into(R_, filled_);
      filled_ = 0;
    }
  }
  num_samples_ += rows.rows();
}

RFactor RFactorBuilder::finish() const {
  RFactor factor{R_, num_terms_, num_samples_};
  RowBlock rest = block_;
  rest.fold_into(factor.R, filled_);
  return factor;
}

RFactor r_factor(Index num_rows, Index num_terms, const Eigen::RowVectorXd& largest, const RowReader& read,
                 int num_threads) {
  const Index width = largest.size();
  if (width <= num_terms) throw std::invalid_argument("r_factor: needs the greatest magnitude of terms and targets");
  const ColumnScale scale(largest);
  std::vector<MatrixXd> shards(static_cast<std::size_t>(std::max<Index>(1, (num_rows + shard_rows - 1) / shard_rows)),
                               MatrixXd::Zero(width, width));
  dsp::for_each_index(shards.size(), threads_for(num_rows, num_threads), [&](std::size_t shard) {
    RowBlock block(rows_a_block, width);
    const Index begin = static_cast<Index>(shard) * shard_rows, end = std::min(num_rows, begin + shard_rows);
    for (Index first = begin; first < end; first += rows_a_block) {
      const Index count = std::min(rows_a_block, end - first);
      read(first, block.rows(0, count));
      if (!block.scale(count, scale.down)) throw std::invalid_argument("r_factor: a value is not finite");
      block.fold_into(shards[shard], count);
    }
  });

  RFactor whole{std::move(shards.front()), num_terms, num_rows};
  RowBlock block(width, width);
  for (std::size_t i = 1; i < shards.size(); ++i) {
    block.rows(0, width) = shards[i];
    block.fold_into(whole.R, width);
  }
  whole.R.array().rowwise() *= scale.up.array();
  return whole;
}

RFactor r_factor(const Eigen::Ref<const MatrixXd>& phi, const Eigen::Ref<const MatrixXd>& targets, int num_threads) {
  if (phi.rows() != targets.rows()) throw std::invalid_argument("r_factor: phi and targets differ in their rows");
  const auto read = [&](Index first, Eigen::Ref<MatrixXd> block) {
    block << phi.middleRows(first, block.rows()), targets.middleRows(first, block.rows());
  };
  Eigen::RowVectorXd largest(phi.cols() + targets.cols());
  dsp::for_each_index(static_cast<std::size_t>(largest.size()), threads_for(phi.rows(), num_threads),
                      [&](std::size_t column) {
                        const auto j = static_cast<Index>(column);
                        largest.segment(j, 1) = largest_of(j < phi.cols() ? phi.col(j) : targets.col(j - phi.cols()));
                      });
  return r_factor(phi.rows(), phi.cols(), largest, read, num_threads);
}

RFactor r_factor(const Eigen::Ref<const MatrixXd>& phi, const Eigen::Ref<const MatrixXd>& targets) {
  return r_factor(phi, targets, 1);
}

RFactor merge(const RFactor& a, const RFactor& b) {
  if (a.R.cols() != b.R.cols() || a.num_terms != b.num_terms)
    throw std::invalid_argument("merge: the R factors belong to different libraries");
  return {folded(a.R, b.R), a.num_terms, a.num_samples + b.num_samples, a.degree};
}

RFactor select(const RFactor& data, const std::vector<Index>& terms, Index target) {
  if (target < 0 || target >= data.num_targets()) throw std::invalid_argument("select: no such target");
  const auto count = static_cast<Index>(terms.size());
  MatrixXd columns(data.R.rows(), count + 1);
  for (Index j = 0; j < count; ++j) {
    const Index term = terms[static_cast<std::size_t>(j)];
    if (term < 0 || term >= data.num_terms) throw std::invalid_argument("select: no such term");
    columns.col(j) = data.R.col(term);
  }
  columns.col(count) = data.R.col(data.num_terms + target);
  return {triangle(columns), count, data.num_samples,
          data.degree.size() > 0 ? Eigen::VectorXd(data.degree(terms)) : Eigen::VectorXd()};
}

}  // namespace ident
