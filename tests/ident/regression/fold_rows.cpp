#include "ident/regression/fold_rows.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using support::gaussian;

TEST_CASE("rows folded into a triangle leave the Gram matrix of both", "[ident][fold_rows]") {
  for (const int lanes : {2, 4, 8}) {
    if (lanes > dsp::vector_lanes()) continue;
    // Every number of columns beyond whole panels and groups of panels, and of rows beyond whole vectors.
    for (const Index width : {1, 2, 3, 4, 5, 7, 8, 11, 31, 32, 33, 37, 70})
      for (const Index count : {0, 1, 5, 8, 40}) {
        const MatrixXd before = gaussian(width, width, 1).triangularView<Eigen::Upper>();
        const MatrixXd rows = gaussian(count, width, 2);
        MatrixXd R = before;
        ident::RowBlock block(64, width);
        block.rows(0, 64).setConstant(std::numeric_limits<double>::quiet_NaN());  // what is not counted is not read
        block.rows(0, count) = rows;
        block.fold_into(R, count, lanes);
        CAPTURE(lanes, width, count);
        const MatrixXd gram = before.transpose() * before + rows.transpose() * rows;
        // Rounding of a Householder QR.
        const double tolerance = static_cast<double>((width + count) * width) * std::numeric_limits<double>::epsilon() *
                                 gram.diagonal().sum();
        CHECK((R.transpose() * R - gram).norm() <= tolerance);
        CHECK(R.isUpperTriangular(0.0));
      }
  }
}

TEST_CASE("columns that others make up, and zero ones, leave a triangle", "[ident][fold_rows]") {
  MatrixXd rows = gaussian(100, 6, 3);
  rows.col(1) = rows.col(0);
  rows.col(3).setZero();
  rows.col(4) = rows.col(2) - rows.col(0);
  MatrixXd R = MatrixXd::Zero(6, 6);
  ident::RowBlock block(100, 6);
  for (int part = 0; part < 3; ++part) {
    block.rows(0, 100) = rows;
    block.fold_into(R, 100);
  }
  CHECK((R.transpose() * R - 3.0 * rows.transpose() * rows).norm() <= 1e-12 * rows.squaredNorm());
  CHECK(R.col(3).isZero(0.0));
  CHECK(std::abs(R(1, 1)) <= 1e-14 * R.col(1).norm());
}
