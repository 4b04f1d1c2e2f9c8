#include "ident/selection/nearest_distant_row.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

std::vector<ident::PointTime> two_records(Index count, Index first_of_other) {
  std::vector<ident::PointTime> times;
  for (Index i = 0; i < count; ++i)
    times.push_back(i < first_of_other ? ident::PointTime{0, 3 * i} : ident::PointTime{1, 3 * (i - first_of_other)});
  return times;
}

bool is_elsewhere(const ident::PointTime& one, const ident::PointTime& other, Index min_separation) {
  return one.record != other.record || std::abs(one.sample - other.sample) > min_separation;
}

/// Against every other point of each.
void check_all(const MatrixXd& points, const std::vector<ident::PointTime>& times, Index min_separation) {
  std::vector<double> least(times.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < times.size(); ++i)
    for (std::size_t j = 0; j < times.size(); ++j)
      if (is_elsewhere(times[i], times[j], min_separation) && i != j)
        least[i] =
            std::min(least[i], (points.col(static_cast<Index>(i)) - points.col(static_cast<Index>(j))).squaredNorm());
  for (const ident::NearPair& pair : ident::nearest_distant_row(points, times, min_separation)) {
    const auto i = static_cast<std::size_t>(pair.points.first), j = static_cast<std::size_t>(pair.points.second);
    REQUIRE(is_elsewhere(times[i], times[j], min_separation));
    // Another order of the sum over the coordinates rounds otherwise.
    CHECK(pair.square == Approx(least[i]).epsilon(1e-14).margin(0.0));
    CHECK((points.col(pair.points.first) - points.col(pair.points.second)).squaredNorm() ==
          Approx(pair.square).epsilon(1e-14).margin(0.0));
    least[i] = std::numeric_limits<double>::infinity();  // has come
  }
  for (const double left : least) CHECK(std::isinf(left));
}

}  // namespace

TEST_CASE("the point nearest elsewhere is that of a search of all", "[ident][selection]") {
  for (const Index dimensions : {2, 3, 5})
    for (const Index min_separation : {0, 1, 40, 5000}) {
      const Index count = 700;
      const auto times = two_records(count, 450);
      const MatrixXd scattered = support::gaussian(dimensions, count, 7 + static_cast<unsigned>(dimensions));
      check_all(scattered, times, min_separation);
      check_all((2.0 * scattered.array()).round() / 2.0, times, min_separation);  // on a grid: ties, and points on cuts
      MatrixXd orbit(dimensions, count);
      for (Index i = 0; i < count; ++i)
        for (Index j = 0; j < dimensions; ++j)
          orbit(j, i) = std::sin(0.05 * static_cast<double>((j + 1) * i) + 0.5 * static_cast<double>(j));
      orbit.row(0).tail(3) *= 1e6;  // the rest all but in one place
      check_all(orbit, times, min_separation);
    }
}

TEST_CASE("points in one place, or neighbouring numbers, are paired with any other elsewhere", "[ident][selection]") {
  MatrixXd points = MatrixXd::Ones(2, 200);
  const auto times = two_records(200, 200);
  CHECK(ident::nearest_distant_row(points, times, 3 * 200).empty());
  check_all(points, times, 30);
  for (Index i = 0; i < 200; ++i) points(0, i) += static_cast<double>(i % 3) * std::numeric_limits<double>::epsilon();
  check_all(points, times, 30);
  CHECK(ident::nearest_distant_row(MatrixXd(2, 0), {}, 1).empty());
}
