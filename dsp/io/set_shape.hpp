#pragma once
#include "dsp/decimate.hpp"

namespace dsp {

/// Its values are lost if its shape changes. Eigen's own `resize` frees the old ones twice where there is no memory for
/// the new ones.
inline void set_shape(FrameBlock& block, Eigen::Index rows, Eigen::Index cols) {
  if (block.rows() != rows || block.cols() != cols) block = FrameBlock(rows, cols);
}

}  // namespace dsp
