#pragma once
#include <Eigen/Core>

#include "dsp/filter/dispatch.hpp"

namespace ident {

/// Rows on their way into the triangle R of a QR factorisation, held as its kernels want them: column after column,
/// each padded with zeros to whole vectors.
class RowBlock {
 public:
  RowBlock(Eigen::Index max_rows, Eigen::Index width);
  [[nodiscard]] Eigen::Index max_rows() const { return max_rows_; }
  /// Rows [first, first + count), to be written or read.
  [[nodiscard]] Eigen::Ref<Eigen::MatrixXd> rows(Eigen::Index first, Eigen::Index count) & {
    return values_.middleRows(first, count);
  }
  [[nodiscard]] Eigen::Ref<const Eigen::MatrixXd> rows(Eigen::Index first, Eigen::Index count) const& {
    return values_.middleRows(first, count);
  }
  void rows(Eigen::Index, Eigen::Index) const&& = delete;
  /// Multiplies the first `count` rows by one factor a column. False if a value is not finite.
  [[nodiscard]] bool scale(Eigen::Index count, const Eigen::RowVectorXd& factors);
  /// Makes the square upper triangle R (width x width) that of [R; the first `count` rows], and spoils those rows.
  /// Householder QR in panels of four reflectors, I - V T V' (compact WY, [SV89]): since R is a triangle already, each
  /// reflector has one element in the rows of R and the others below. Values are of size 1: their squares must not
  /// overflow, and what is below 1e-140 counts as zero. `lanes`: 8, 4 or 2, no more than the processor has; the last
  /// bits depend on it. LAPACK's dtpqrt makes the same triangle, in 9 to 13 times the time with Debian's own BLAS and
  /// in 3.7 to 5 times with OpenBLAS (512 rows of 12 to 64 columns).
  void fold_into(Eigen::Ref<Eigen::MatrixXd> R, Eigen::Index count, int lanes = dsp::vector_lanes());

 private:
  void pad(Eigen::Index count);
  Eigen::Index max_rows_;
  Eigen::MatrixXd values_;
};

}  // namespace ident
