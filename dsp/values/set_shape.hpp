#pragma once
#include <Eigen/Core>

namespace dsp {

/// Gives a matrix or vector this shape; where it had another its values are lost. Eigen's own `resize` frees the old
/// ones twice where there is no memory for the new ones.
template <class Values>
void set_shape(Eigen::PlainObjectBase<Values>& values, Eigen::Index rows, Eigen::Index cols = 1) {
  if (values.rows() != rows || values.cols() != cols) values.derived() = Values(rows, cols);
}

}  // namespace dsp
