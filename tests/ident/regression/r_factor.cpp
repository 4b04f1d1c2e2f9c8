#include "ident/regression/r_factor.hpp"

#include <rapidcheck/catch.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using support::gaussian;

namespace {

// R is unique up to the signs of its rows, so R'R is compared; Householder QR rounds by about m b eps.
double distance(const MatrixXd& a, const MatrixXd& b) {
  return (a.transpose() * a - b.transpose() * b).norm();
}
double rounding(Index rows, const MatrixXd& R) {
  return static_cast<double>(rows * R.cols()) * std::numeric_limits<double>::epsilon() * R.squaredNorm();
}

ident::RFactor in_blocks(const MatrixXd& rows, Index num_terms, Index block) {
  ident::RFactorBuilder builder(num_terms, rows.cols() - num_terms);
  for (Index first = 0; first < rows.rows(); first += block)
    builder.push(rows.middleRows(first, std::min(block, rows.rows() - first)));
  return builder.finish();
}

}  // namespace

TEST_CASE("R'R equals the Gram matrix of terms and target", "[ident][r_factor]") {
  const MatrixXd phi = gaussian(1500, 6, 1), target = gaussian(1500, 1, 2);
  const auto data = ident::r_factor(phi, target);
  MatrixXd both(1500, 7);
  both << phi, target;
  CHECK(distance(data.R, both) <= rounding(1500, data.R));
  CHECK(data.num_samples == 1500);
  CHECK(data.num_terms == 6);
}

TEST_CASE("the rows give the same bits however they are cut into blocks", "[ident][r_factor]") {
  const MatrixXd rows = gaussian(3001, 9, 3);
  const MatrixXd whole = in_blocks(rows, 8, rows.rows()).R;
  for (const Index block : {Index{1}, Index{7}, Index{256}, Index{1000}}) CHECK(in_blocks(rows, 8, block).R == whole);
}

TEST_CASE("one thread and two give the same bits", "[ident][r_factor]") {
  const MatrixXd phi = gaussian(140000, 5, 4), target = gaussian(140000, 1, 5);
  const MatrixXd one = ident::r_factor(phi, target, 1).R;
  CHECK(ident::r_factor(phi, target, 2).R == one);
  CHECK(ident::r_factor(phi, target, 3).R == one);
}

TEST_CASE("rows read block by block give the bits of the matrix in memory", "[ident][r_factor]") {
  const MatrixXd phi = 1e-160 * gaussian(3001, 5, 4), target = 1e160 * gaussian(3001, 1, 5);
  const auto read = [&](Index first, Eigen::Ref<MatrixXd> block) {
    block << phi.middleRows(first, block.rows()), target.middleRows(first, block.rows());
  };
  Eigen::RowVectorXd largest(6);
  largest << phi.cwiseAbs().colwise().maxCoeff(), target.cwiseAbs().maxCoeff();
  CHECK(ident::r_factor(3001, 5, largest, read, 2).R == ident::r_factor(phi, target).R);
  const auto spoilt = [&](Index first, Eigen::Ref<MatrixXd> block) {
    read(first, block);
    if (first > 0) block(0, 2) = std::numeric_limits<double>::quiet_NaN();
  };
  CHECK_THROWS_AS(ident::r_factor(3001, 5, largest, spoilt), std::invalid_argument);
  CHECK_THROWS_AS(ident::r_factor(3001, 5, largest.head(5), read), std::invalid_argument);
}

TEST_CASE("rows are read once where the greatest magnitudes are known", "[ident][r_factor]") {
  const MatrixXd rows = gaussian(3001, 6, 4);
  Index num_read = 0;
  const auto read = [&](Index first, Eigen::Ref<MatrixXd> block) {
    block = rows.middleRows(first, block.rows());
    num_read += block.rows();
  };
  (void)ident::r_factor(3001, 5, rows.cwiseAbs().colwise().maxCoeff(), read);
  CHECK(num_read == 3001);
}

TEST_CASE("merging shards in any order equals factoring the stacked rows", "[ident][r_factor]") {
  rc::prop("any sharding", [] {
    const auto cuts = *rc::gen::container<std::vector<int>>(4, rc::gen::inRange(0, 700));
    const MatrixXd phi = gaussian(700, 5, 6), target = gaussian(700, 2, 7);
    std::vector<int> edges{0, 700};
    edges.insert(edges.end(), cuts.begin(), cuts.end());
    std::sort(edges.begin(), edges.end());
    // A shuffle of five, from one number.
    auto code = *rc::gen::inRange(0, 120);
    std::vector<std::size_t> order{0, 1, 2, 3, 4};
    for (; code > 0; --code) std::next_permutation(order.begin(), order.end());
    ident::RFactor sum;
    for (const std::size_t shard : order) {
      const Index first = edges[shard], count = edges[shard + 1] - first;
      const auto part = ident::r_factor(phi.middleRows(first, count), target.middleRows(first, count));
      sum = sum.R.size() == 0 ? part : ident::merge(sum, part);
    }
    const auto whole = ident::r_factor(phi, target);
    RC_ASSERT(sum.num_samples == 700);
    RC_ASSERT(distance(sum.R, whole.R) <= rounding(700, whole.R));
    // What a fit reads off: the residual norm, to 1e-12 of itself.
    const double residual = std::abs(ident::select(whole, {0, 1, 2, 3, 4}, 0).R(5, 5));
    RC_ASSERT(std::abs(std::abs(ident::select(sum, {0, 1, 2, 3, 4}, 0).R(5, 5)) - residual) <= 1e-12 * residual);
  });
}

TEST_CASE("columns near the ends of the number range neither overflow nor vanish", "[ident][r_factor]") {
  MatrixXd phi = gaussian(300, 3, 8);
  const auto plain = ident::r_factor(phi, gaussian(300, 1, 9));
  phi.col(0) *= 0x1p1000;
  phi.col(2) *= 0x1p-1000;
  const auto scaled = ident::r_factor(phi, gaussian(300, 1, 9));
  CHECK(scaled.R.col(0) == plain.R.col(0) * 0x1p1000);  // powers of two: exact
  CHECK(scaled.R.col(2) == plain.R.col(2) * 0x1p-1000);
}

TEST_CASE("rows that are not finite or do not fit are refused", "[ident][r_factor]") {
  MatrixXd phi = gaussian(10, 2, 10);
  CHECK_THROWS_AS(ident::r_factor(phi, gaussian(9, 1, 11)), std::invalid_argument);
  phi(3, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(ident::r_factor(phi, gaussian(10, 1, 11)), std::invalid_argument);
  CHECK_THROWS_AS(ident::RFactorBuilder(2, 1).push(gaussian(4, 2, 12)), std::invalid_argument);
  CHECK_THROWS_AS(ident::RFactorBuilder(2, 0), std::invalid_argument);
  CHECK_THROWS_AS(ident::merge(ident::r_factor(gaussian(10, 2, 13), gaussian(10, 1, 11)),
                               ident::r_factor(gaussian(10, 3, 14), gaussian(10, 1, 11))),
                  std::invalid_argument);
}
