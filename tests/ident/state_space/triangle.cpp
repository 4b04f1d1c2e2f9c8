#include "ident/state_space/triangle.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/random.hpp"

using Eigen::Index;
using ident::state_space::Triangle;

namespace {

constexpr int columns = 5;
const Eigen::MatrixXd rows = support::gaussian(300, columns + 1, 3);  // of A and b

Triangle folded(Index first, Index last) {
  Triangle triangle(columns);
  for (Index i = first; i < last; ++i) {
    const Eigen::VectorXd row = rows.row(i);
    triangle.add(row.data());
  }
  triangle.fold();
  return triangle;
}

Eigen::VectorXd vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Index>(values.size()));
}

}  // namespace

TEST_CASE("at the least the gradient vanishes, with a linear part as without", "[ident][state_space]") {
  const Triangle triangle = folded(0, 300);
  const auto A = rows.leftCols(columns);
  const auto b = rows.col(columns);
  for (const std::vector<double>& linear : {std::vector<double>{}, std::vector<double>{3.0, -1.0, 0.5, 7.0, 2.0}}) {
    const Eigen::VectorXd x = vector(triangle.solve(linear));
    Eigen::VectorXd gradient = 2.0 * A.transpose() * (A * x - b);
    if (!linear.empty()) gradient += vector(linear);
    CHECK(gradient.norm() < 1e-10);
    const double value = (A * x - b).squaredNorm() + (linear.empty() ? 0.0 : vector(linear).dot(x));
    CHECK(triangle.value(triangle.solve(linear), linear) == Approx(value).epsilon(1e-12));
  }
}

TEST_CASE("the covariance is the inverse of the Gram matrix", "[ident][state_space]") {
  const std::vector<double> covariance = folded(0, 300).covariance();
  const Eigen::MatrixXd C = Eigen::Map<const Eigen::MatrixXd>(covariance.data(), columns, columns);
  CHECK((C * rows.leftCols(columns).transpose() * rows.leftCols(columns)).isIdentity(1e-12));
}

TEST_CASE("triangles add up as their rows do, and subsets are those of the rows", "[ident][state_space]") {
  Triangle sum = folded(0, 120);
  sum.add(folded(120, 300));
  sum.fold();
  const Triangle whole = folded(0, 300);
  CHECK((vector(sum.solve()) - vector(whole.solve())).norm() < 1e-13);
  CHECK(sum.left_over() == Approx(whole.left_over()).epsilon(1e-13));
  Triangle few(2);
  for (Index i = 0; i < 300; ++i) {
    const double row[3] = {rows(i, 3), rows(i, 1), rows(i, columns)};
    few.add(row);
  }
  few.fold();
  CHECK((vector(whole.only({3, 1}).solve()) - vector(few.solve())).norm() < 1e-13);
  CHECK(whole.only({3, 1}).left_over() == Approx(few.left_over()).epsilon(1e-13));
}

TEST_CASE("steps become values when counted from elsewhere", "[ident][state_space]") {
  const std::vector<double> x0{1.0, -2.0, 0.5, 3.0, 0.0};
  const Triangle triangle = folded(0, 300);
  CHECK((vector(triangle.from(x0).solve()) - vector(triangle.solve()) - vector(x0)).norm() < 1e-13);
}

TEST_CASE("a column without rows is left at zero and infinitely uncertain", "[ident][state_space]") {
  Triangle triangle(2);
  const double row[3] = {2.0, 0.0, 4.0};
  triangle.add(row);
  triangle.fold();
  CHECK(triangle.solve() == std::vector<double>{2.0, 0.0});
  CHECK(triangle.covariance()[0] == Approx(0.25));
  CHECK(std::isinf(triangle.covariance()[3]));
}
