#include "ident/switches/anderson_mixing.hpp"

#include <Eigen/LU>
#include <catch2/catch.hpp>

using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST_CASE("mixing finds the solution that a swinging iteration moves away from", "[ident][anderson_mixing]") {
  // Three eigenvalues, one beyond -1: x -> g(x) goes ever farther away.
  const VectorXd solution = (VectorXd(4) << 1.0, -2.0, 300.0, 0.5).finished();
  MatrixXd basis(4, 4);
  basis << 1, 2, 0, 1, 0, 1, -1, 3, 200, 0, 100, 0, 1, 1, 1, -1;
  const VectorXd eigenvalues = (VectorXd(4) << -1.05, 0.3, -0.6, 0.3).finished();
  const MatrixXd slope = basis * eigenvalues.asDiagonal() * basis.inverse();
  const auto g = [&](const VectorXd& x) { return VectorXd(solution + slope * (x - solution)); };

  VectorXd plain = VectorXd::Zero(4);
  for (int pass = 0; pass < 20; ++pass) plain = g(plain);
  CHECK((plain - solution).norm() > solution.norm());

  ident::AndersonMixing mixing((VectorXd(4) << 1.0, 1.0, 0.01, 1.0).finished());
  VectorXd x = VectorXd::Zero(4);
  CHECK(mixing.next(x, g(x)) == g(x));
  x = g(x);
  for (int pass = 0; pass < 3; ++pass) x = mixing.next(x, g(x));
  CHECK((x - solution).norm() < 1e-11 * solution.norm());  // rounding, times the condition of the basis: 1e3
  x = mixing.next(x, g(x));                                // and stays, where steps are nothing but rounding
  CHECK((x - solution).norm() < 1e-11 * solution.norm());
}
