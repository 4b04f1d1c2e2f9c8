#include "ident/validate/independent_rows.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

#include "support/random.hpp"

using Eigen::Index;
using Eigen::VectorXd;

namespace {

std::vector<Index> samples_with_gap(Index count) {
  std::vector<Index> samples;
  for (Index i = 0; i < count; ++i) samples.push_back(i < count / 2 ? i : i + 1000);
  return samples;
}

}  // namespace

TEST_CASE("a white residual counts in full, a coloured one as its autocorrelation says", "[ident][independent_rows]") {
  const Index n = 20000;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const VectorXd white = support::gaussian(n, 1, 500 + seed);
    // Chance passes the threshold for one lag in a hundred or so, and then adds 2e-3.
    CHECK(ident::independent_fraction(white, samples_with_gap(n)) > 0.98);
    VectorXd coloured = white;
    for (Index i = 1; i < n; ++i) coloured(i) += 0.6 * coloured(i - 1);
    // sum of 0.6^(2 l): 1 / (1 + 2 * 0.5625). Lags under the threshold are missing, and chance lags of a coloured
    // residual pass it more often than those of a white one: the safe side.
    const double fraction = ident::independent_fraction(coloured, samples_with_gap(n));
    CHECK(fraction > 0.8 / 2.125);
    CHECK(fraction < 1.05 / 2.125);
  }
}

TEST_CASE("no residual, and next to none, is as good as white", "[ident][independent_rows]") {
  CHECK(ident::independent_fraction(VectorXd::Zero(100), samples_with_gap(100)) == 1.0);
  CHECK(ident::independent_fraction(VectorXd::Ones(2), {0, 1}) == 1.0);
}

TEST_CASE("a periodic residual counts as two numbers for each harmonic, however many cycles there are",
          "[ident][independent_rows]") {
  const Index n = 2500;  // ten cycles
  for (const int harmonics : {1, 3, 6, 12}) {
    VectorXd residual = VectorXd::Zero(n);
    for (int h = 1; h <= harmonics; ++h)
      for (Index i = 0; i < n; ++i)
        residual(i) += std::cos(
            2.0 * static_cast<double>(EIGEN_PI) * 10.0 * h * static_cast<double>(i) / static_cast<double>(n) + h * h);
    std::vector<Index> samples;
    for (Index i = 0; i < n; ++i) samples.push_back(i);
    // The squared autocorrelation of H equal lines sums up to n / (2 H) over the record; chance lags are not counted.
    CHECK(static_cast<double>(n) * ident::IndependentRows(samples).fraction(residual) ==
          Approx(2.0 * harmonics).epsilon(0.2));
  }
}

TEST_CASE("lags do not cross from one record to the next", "[ident][independent_rows]") {
  // The second record repeats the first, which is white but for chance: across the border the correlation is one.
  const VectorXd white = support::gaussian(500, 1, 77);
  VectorXd both(1000);
  both << white, white;
  std::vector<Index> samples;
  for (Index i = 0; i < 1000; ++i) samples.push_back(i);
  CHECK(ident::IndependentRows(samples, {0, 500}).fraction(both) > 0.9);
  CHECK(ident::IndependentRows(samples).fraction(both) < 0.75);
}

TEST_CASE("evidence for a regressor counts the lags at which the residual is correlated, few or many",
          "[ident][independent_rows]") {
  const Index n = 4000;
  const std::vector<Index> samples = samples_with_gap(n);
  const ident::IndependentRows rows(samples, {0, n / 4});
  VectorXd regressor = support::gaussian(n, 1, 70), short_memory = support::gaussian(n, 1, 71);
  for (Index i = 1; i < n; ++i) regressor(i) += 0.8 * regressor(i - 1), short_memory(i) += 0.7 * short_memory(i - 1);
  VectorXd tone(n);
  for (Index i = 0; i < n; ++i) tone(i) = std::sin(0.05 * static_cast<double>(i));
  for (const VectorXd& residual : {VectorXd(support::gaussian(n, 1, 72)), short_memory, tone}) {
    // Pairs of rows within a record, counted lag by lag; with few lags beyond chance another way leads there.
    const VectorXd r = rows.autocorrelation(residual), other = rows.autocorrelation(regressor);
    double sum = 0.0;
    for (Index lag = 1; lag < r.size(); ++lag) {
      double pairs = 0.0;
      for (const auto& [first, last] : {std::pair<Index, Index>{0, n / 4}, {n / 4, n}})
        for (Index i = first; i < last; ++i) {
          const Index sample = samples[static_cast<std::size_t>(i)] + lag;
          pairs += std::binary_search(samples.begin() + i, samples.begin() + last, sample) ? 1.0 : 0.0;
        }
      if (r(lag) * r(lag) * pairs > 2.0 * std::log(static_cast<double>(n)))
        sum += pairs / static_cast<double>(n) * r(lag) * other(lag);
    }
    CHECK(rows.fraction_beside(r, regressor) == Approx(1.0 / (1.0 + 2.0 * std::max(0.0, sum))).epsilon(1e-9));
  }
}
