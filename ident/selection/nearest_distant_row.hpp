#pragma once
#include <Eigen/Core>
#include <tuple>
#include <utility>
#include <vector>

namespace ident {

/// Two rows in nearly the same state.
using RowPair = std::pair<Eigen::Index, Eigen::Index>;

/// When a point was passed: in which record, at which sample of it.
struct PointTime {
  Eigen::Index record = 0, sample = 0;
};

struct NearPair {
  double square = 0.0;  ///< of the distance
  RowPair points;       ///< a point, and the one nearest to it
  bool operator<(const NearPair& other) const {
    return std::tie(square, points) < std::tie(other.square, other.points);
  }
};

/// Each point, a column of `points`, with the nearest that is of another record or more than `min_separation` samples
/// away, where there is one; of several equally near with any, always the same. In no order. As many times as points.
[[nodiscard]] std::vector<NearPair> nearest_distant_row(const Eigen::Ref<const Eigen::MatrixXd>& points,
                                                        const std::vector<PointTime>& times,
                                                        Eigen::Index min_separation);

}  // namespace ident
