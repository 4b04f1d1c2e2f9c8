#include "ident/r_factor.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "dsp/for_each_index.hpp"

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// A leaf holds enough rows to make its Householder QR worth while and few enough to stay in cache. It depends on the
// width alone, so the tree is the same however the rows arrive.
Index leaf_rows(Index width) {
  return std::max<Index>(256, 4 * width);
}

// Leaves in one shard: the unit handed to a thread, a whole subtree of the binary tree.
constexpr Index shard_leaves = 64;

MatrixXd triangle(MatrixXd rows) {
  const Index width = rows.cols();
  if (rows.rows() == 0) return MatrixXd::Zero(width, width);
  Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> qr(rows);
  MatrixXd R = MatrixXd::Zero(width, width);
  const Index height = std::min(rows.rows(), width);
  R.topRows(height) = rows.topRows(height).triangularView<Eigen::Upper>();
  return R;
}

MatrixXd merged(const MatrixXd& upper, const MatrixXd& lower) {
  MatrixXd stacked(upper.rows() + lower.rows(), upper.cols());
  stacked << upper, lower;
  return triangle(std::move(stacked));
}

}  // namespace

std::vector<Index> all_columns(Index count) {
  std::vector<Index> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), Index{0});
  return all;
}

RFactorBuilder::RFactorBuilder(Index num_terms, Index num_targets)
    : num_terms_(num_terms),
      num_targets_(num_targets),
      leaf_(leaf_rows(num_terms + num_targets), num_terms + num_targets) {
  if (num_terms < 0 || num_targets < 1)
    throw std::invalid_argument("RFactorBuilder: needs terms >= 0 and targets >= 1");
}

void RFactorBuilder::push(const Eigen::Ref<const MatrixXd>& rows) {
  if (rows.cols() != leaf_.cols()) throw std::invalid_argument("RFactorBuilder::push: rows have another width");
  for (Index done = 0; done < rows.rows();) {
    const Index count = std::min(leaf_.rows() - filled_, rows.rows() - done);
    leaf_.middleRows(filled_, count) = rows.middleRows(done, count);
    filled_ += count;
    done += count;
    if (filled_ == leaf_.rows()) {
      fold(0, triangle(leaf_));
      filled_ = 0;
    }
  }
  num_samples_ += rows.rows();
}

void RFactorBuilder::fold(int level, MatrixXd R) {
  const auto index = static_cast<std::size_t>(level);
  if (index == levels_.size()) levels_.emplace_back();
  if (levels_[index].size() == 0) {
    levels_[index] = std::move(R);
    return;
  }
  MatrixXd both = merged(levels_[index], R);
  levels_[index].resize(0, 0);
  fold(level + 1, std::move(both));
}

RFactor RFactorBuilder::finish() const {
  MatrixXd R = triangle(leaf_.topRows(filled_));
  for (const MatrixXd& level : levels_)
    if (level.size() != 0) R = merged(level, R);
  return {std::move(R), num_terms_, num_samples_};
}

RFactor r_factor(Index num_rows, Index num_terms, const Eigen::RowVectorXd& largest, const RowReader& read,
                 int num_threads) {
  const Index width = largest.size(), leaf = leaf_rows(width), shard_rows = shard_leaves * leaf;
  if (width <= num_terms) throw std::invalid_argument("r_factor: needs the greatest magnitude of terms and targets");
  const Index num_shards = std::max<Index>(1, (num_rows + shard_rows - 1) / shard_rows);
  // Powers of two taken out of each column: exact, and no square overflows or vanishes.
  const Eigen::RowVectorXd scale = largest.unaryExpr(
      [](double value) { return value > 0.0 && std::isfinite(value) ? std::ldexp(1.0, std::ilogb(value)) : 1.0; });

  std::vector<RFactor> shards(static_cast<std::size_t>(num_shards));
  dsp::for_each_index(shards.size(), num_threads, [&](std::size_t index) {
    const auto shard = static_cast<Index>(index);
    RFactorBuilder builder(num_terms, width - num_terms);
    const Index end = std::min(num_rows, (shard + 1) * shard_rows);
    MatrixXd rows;
    for (Index first = shard * shard_rows; first < end; first += leaf) {
      rows.resize(std::min(leaf, end - first), width);
      read(first, rows);
      if (!rows.allFinite()) throw std::invalid_argument("r_factor: a value is not finite");
      rows.array().rowwise() /= scale.array();
      builder.push(rows);
    }
    shards[index] = builder.finish();
  });

  RFactor whole = shards.front();
  for (std::size_t i = 1; i < shards.size(); ++i) whole = merge(whole, shards[i]);
  whole.R.array().rowwise() *= scale.array();
  return whole;
}

RFactor r_factor(const Eigen::Ref<const MatrixXd>& phi, const Eigen::Ref<const MatrixXd>& targets, int num_threads) {
  if (phi.rows() != targets.rows()) throw std::invalid_argument("r_factor: phi and targets differ in their rows");
  const auto read = [&](Index first, Eigen::Ref<MatrixXd> block) {
    block << phi.middleRows(first, block.rows()), targets.middleRows(first, block.rows());
  };
  Eigen::RowVectorXd largest = Eigen::RowVectorXd::Zero(phi.cols() + targets.cols());
  if (phi.rows() > 0) {
    largest.head(phi.cols()) = phi.cwiseAbs().colwise().maxCoeff();
    largest.tail(targets.cols()) = targets.cwiseAbs().colwise().maxCoeff();
  }
  return r_factor(phi.rows(), phi.cols(), largest, read, num_threads);
}

RFactor r_factor(const Eigen::Ref<const MatrixXd>& phi, const Eigen::Ref<const MatrixXd>& targets) {
  return r_factor(phi, targets, 1);
}

RFactor merge(const RFactor& a, const RFactor& b) {
  if (a.R.cols() != b.R.cols() || a.num_terms != b.num_terms)
    throw std::invalid_argument("merge: the R factors belong to different libraries");
  return {merged(a.R, b.R), a.num_terms, a.num_samples + b.num_samples};
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
  return {triangle(std::move(columns)), count, data.num_samples};
}

}  // namespace ident
