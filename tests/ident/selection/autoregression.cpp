#include "ident/selection/autoregression.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

VectorXd coloured(Index count, double rho, unsigned seed) {
  VectorXd values = support::gaussian(count, 1, seed);
  for (Index i = 1; i < count; ++i) values(i) = rho * values(i - 1) + std::sqrt(1.0 - rho * rho) * values(i);
  return values;
}

double found(const MatrixXd& columns, const VectorXd& target, const std::vector<unsigned char>& begins) {
  Eigen::RowVectorXd largest(columns.cols() + 1);
  largest << columns.cwiseAbs().colwise().maxCoeff(), target.cwiseAbs().maxCoeff();
  return ident::autoregression(
      columns.rows(), columns.cols(), largest,
      [&](Index first, Eigen::Ref<MatrixXd> block) {
        block << columns.middleRows(first, block.rows()), target.segment(first, block.rows());
      },
      begins, 1);
}

}  // namespace

TEST_CASE("the autoregression of a residual is found, also where terms take a part of it", "[ident][selection]") {
  const Index n = 2000;
  std::vector<Index> samples;
  for (Index i = 0; i < n; ++i) samples.push_back(i < n / 2 ? i : i + 100);  // two runs
  const auto begins = ident::run_begins(samples, {0});
  MatrixXd columns(n, 6);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < 6; ++j)
      columns(i, j) =
          std::cos(0.01 * static_cast<double>(j) * static_cast<double>(samples[static_cast<std::size_t>(i)]));
  for (const double rho : {0.0, 0.5, 0.9, 0.99}) {
    double sum = 0.0;
    constexpr int draws = 20;
    for (unsigned seed = 0; seed < draws; ++seed) sum += found(columns, coloured(n, rho, 60 + seed), begins) / draws;
    // One draw scatters by sqrt((1 - rho^2) / n); four deviations of the mean of twenty, and 5e-3 of bias near 1.
    CHECK(sum == Approx(rho).margin(4.0 * std::sqrt((1.0 - rho * rho) / n / draws) + 5e-3 * rho));
  }
}

TEST_CASE("whitened rows are white, whatever the cut into blocks", "[ident][selection]") {
  const Index n = 400;
  const VectorXd values = coloured(n, 0.9, 5);
  std::vector<unsigned char> begins(static_cast<std::size_t>(n), 0);
  begins[0] = begins[250] = 1;
  const VectorXd once = ident::whitened_values(values, begins, 0.9);
  const ident::RowReader read = ident::whitened(
      [&](Index first, Eigen::Ref<MatrixXd> block) { block = values.segment(first, block.rows()); }, begins, 0.9);
  MatrixXd in_blocks(n, 1);
  for (Index first = 0; first < n; first += 40) read(first, in_blocks.middleRows(first, 40));
  CHECK(in_blocks.col(0) == once);
  CHECK(once(0) == Approx(std::sqrt(1.0 - 0.81) * values(0)));
  CHECK(once(250) == Approx(std::sqrt(1.0 - 0.81) * values(250)));
  CHECK(once(100) == Approx(values(100) - 0.9 * values(99)));
}
