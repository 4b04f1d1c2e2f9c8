#include "ident/selection/best_subsets.hpp"

#include <Eigen/QR>
#include <catch2/catch.hpp>
#include <limits>

#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST_CASE("the best subset of each size is that of an exhaustive search", "[ident][selection]") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    MatrixXd phi = support::gaussian(60, 8, 40 + seed);
    phi.col(1) = 0.9 * phi.col(0) + 0.3 * phi.col(1);  // forward selection alone takes the wrong one of these
    phi.col(2) = 0.7 * phi.col(0) - 0.7 * phi.col(1) + 0.2 * phi.col(2);
    const VectorXd target = phi.col(0) - phi.col(1) + 0.3 * phi.col(5) + 0.1 * support::gaussian(60, 1, 900 + seed);
    const ident::UnitProblem problem = ident::unit_problem(ident::r_factor(phi, target));
    const auto path = ident::best_subsets(problem, 8);
    REQUIRE(path.size() == 9);
    std::vector<double> least(9, std::numeric_limits<double>::infinity());
    for (unsigned mask = 0; mask < 256; ++mask) {
      MatrixXd columns(60, 0);
      for (Index j = 0; j < 8; ++j)
        if (((mask >> j) & 1U) != 0) {
          columns.conservativeResize(60, columns.cols() + 1);
          columns.rightCols(1) = phi.col(j);
        }
      VectorXd left = target;
      if (columns.cols() > 0) left -= columns * columns.householderQr().solve(target);
      double& best = least[static_cast<std::size_t>(columns.cols())];
      best = std::min(best, left.squaredNorm() / target.squaredNorm());
    }
    for (std::size_t size = 0; size < path.size(); ++size) {
      CHECK(std::ssize(path[size].terms) == static_cast<Index>(size));
      CHECK(path[size].rss == Approx(least[size]).epsilon(1e-9));
    }
  }
}
