#pragma once
#include <Eigen/Core>
#include <random>

namespace support {

/// rows x cols independent standard normal numbers, the same for the same seed.
inline Eigen::MatrixXd gaussian(Eigen::Index rows, Eigen::Index cols, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd values(rows, cols);
  for (Eigen::Index j = 0; j < cols; ++j)
    for (Eigen::Index i = 0; i < rows; ++i) values(i, j) = normal(engine);
  return values;
}

}  // namespace support
