#include "ident/selection/nearest_distant_row.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace ident {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A tree of the points, each node of which cuts the box they fill in half along its longest side (Bentley,
/// Communications of the ACM 18, 1975).
class PointTree {
 public:
  PointTree(const Eigen::Ref<const MatrixXd>& points, const std::vector<PointTime>& times, Index min_separation)
      : min_separation_(min_separation), order_(static_cast<std::size_t>(points.cols())) {
    std::iota(order_.begin(), order_.end(), Index{0});
    if (points.cols() > 0) split(points, 0, points.cols());
    points_ = points(Eigen::all, order_);
    for (const Index point : order_) times_.push_back(times[static_cast<std::size_t>(point)]);
  }

  [[nodiscard]] std::vector<NearPair> pairs() const {
    std::vector<NearPair> result;
    for (Index place = 0; place < std::ssize(order_); ++place) {
      Search search{place};
      look_in(0, search);
      if (search.nearest >= 0) result.push_back({search.square, {point(place), point(search.nearest)}});
    }
    return result;
  }

 private:
  static constexpr Index most_in_leaf = 12;  // so many are compared faster than they are parted
  struct Node {
    Index begin = 0, end = 0;  ///< places
    Index coordinate = 0;
    double split = 0.0;  ///< the coordinate's largest value in the half that is the next node
    Index above = 0;     ///< the node of the other half; 0: a leaf
  };
  struct Search {
    Index place = 0, nearest = -1;
    double square = std::numeric_limits<double>::infinity();
  };
  [[nodiscard]] Index point(Index place) const { return order_[static_cast<std::size_t>(place)]; }

  void split(const Eigen::Ref<const MatrixXd>& points, Index begin, Index end) {
    const auto index = nodes_.size();
    nodes_.push_back({begin, end});
    if (end - begin <= most_in_leaf) return;
    VectorXd low = points.col(order_[static_cast<std::size_t>(begin)]), high = low;
    for (Index place = begin; place < end; ++place) {
      low = low.cwiseMin(points.col(order_[static_cast<std::size_t>(place)]));
      high = high.cwiseMax(points.col(order_[static_cast<std::size_t>(place)]));
    }
    Index widest = 0;
    if (!((high - low).maxCoeff(&widest) > 0.0)) return;  // all in one place
    double middle = low(widest) + 0.5 * (high(widest) - low(widest));
    if (!(middle < high(widest))) middle = low(widest);  // no number lies between them
    const auto above = std::partition(order_.begin() + begin, order_.begin() + end,
                                      [&](Index one) { return points(widest, one) <= middle; }) -
                       order_.begin();
    nodes_[index].coordinate = widest;
    nodes_[index].split = middle;
    split(points, begin, above);
    nodes_[index].above = std::ssize(nodes_);
    split(points, above, end);
  }

  void look_in(Index index, Search& search) const {
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (node.above == 0) return compare(node, search);
    const double beyond = points_(node.coordinate, search.place) - node.split;
    look_in(beyond <= 0.0 ? index + 1 : node.above, search);
    if (beyond * beyond < search.square) look_in(beyond <= 0.0 ? node.above : index + 1, search);
  }

  void compare(const Node& leaf, Search& search) const {
    for (Index other = leaf.begin; other < leaf.end && search.square > 0.0; ++other) {
      double square = 0.0;
      for (Index i = 0; i < points_.rows(); ++i) {
        const double along = points_(i, other) - points_(i, search.place);
        square += along * along;
      }
      if (square < search.square && is_elsewhere(other, search.place)) search.square = square, search.nearest = other;
    }
  }

  [[nodiscard]] bool is_elsewhere(Index other, Index place) const {
    const PointTime &one = times_[static_cast<std::size_t>(place)], &two = times_[static_cast<std::size_t>(other)];
    return one.record != two.record || std::abs(one.sample - two.sample) > min_separation_;
  }

  Index min_separation_;
  std::vector<Index> order_;  ///< point at each place
  MatrixXd points_;           ///< by places
  std::vector<PointTime> times_;
  std::vector<Node> nodes_;
};

}  // namespace

std::vector<NearPair> nearest_distant_row(const Eigen::Ref<const MatrixXd>& points, const std::vector<PointTime>& times,
                                          Index min_separation) {
  return PointTree(points, times, min_separation).pairs();
}

}  // namespace ident
