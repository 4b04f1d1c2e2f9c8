#include "ident/validate/metrics.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

#include "ident/regression/fit.hpp"
#include "support/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using support::gaussian;

namespace {

std::vector<Index> every_sample(Index count) {
  std::vector<Index> samples(static_cast<std::size_t>(count));
  std::iota(samples.begin(), samples.end(), Index{0});
  return samples;
}

}  // namespace

TEST_CASE("NMSE as the paper defines it and about the mean", "[ident][metrics]") {
  const VectorXd actual{{1.0, 2.0, 3.0}}, predicted{{1.0, 2.0, 4.0}};
  CHECK(ident::nmse(predicted, actual) == Approx(1.0 / 14.0));
  CHECK(ident::nmse_centred(predicted, actual) == Approx(1.0 / 2.0));
  CHECK(std::isnan(ident::nmse(predicted, VectorXd::Zero(3))));
  CHECK(std::isnan(ident::nmse_centred(predicted, VectorXd::Constant(3, 0.1))));
}

TEST_CASE("predictive bands hold the fraction of new targets they promise", "[ident][metrics]") {
  // Few rows, so that the coefficients' own uncertainty is a visible part of the variance.
  ident::BandFractions mean;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const MatrixXd phi = gaussian(40, 3, 3 * seed);
    const VectorXd c{{1.0, -2.0, 0.5}};
    const auto fit = ident::fit_ols(ident::r_factor(phi, phi * c + 0.3 * gaussian(40, 1, 3 * seed + 1)));
    const MatrixXd fresh = 3.0 * gaussian(10, 3, 3 * seed + 2);
    const VectorXd target = fresh * c + 0.3 * gaussian(10, 1, 90000 + seed);
    const auto fractions = ident::band_fractions(
        fresh * fit.mean, ident::predictive_variance(fresh, fit.covariance, fit.noise_variance), target);
    mean.within_50 += fractions.within_50 / 300.0;
    mean.within_90 += fractions.within_90 / 300.0;
    mean.within_95 += fractions.within_95 / 300.0;
  }
  // 3000 rows in clusters of ten: four standard errors of 300 independent clusters at the worst; Student's t with 37
  // degrees of freedom takes 0.7 % off the 95 % band.
  CHECK(mean.within_50 == Approx(0.5).margin(0.05));
  CHECK(mean.within_90 == Approx(0.892).margin(0.03));
  CHECK(mean.within_95 == Approx(0.943).margin(0.02));
}

TEST_CASE("a white residual passes, a tone in it does not", "[ident][metrics]") {
  const Index n = 4000;
  int refused = 0;
  for (unsigned seed = 0; seed < 200; ++seed)
    refused += !ident::residual_whiteness(gaussian(n, 1, seed), every_sample(n), 100.0, 50.0).white;
  CHECK(refused <= 8);  // expected 2 at a level of 0.01, this is four standard deviations more
  VectorXd tonal = gaussian(n, 1, 7);
  for (Index i = 0; i < n; ++i)
    tonal(i) += 0.3 * std::sin(2.0 * std::numbers::pi * 3.0 * static_cast<double>(i) / 100.0);
  const auto judged = ident::residual_whiteness(tonal, every_sample(n), 100.0, 50.0);
  CHECK_FALSE(judged.white);
  const auto pure = ident::residual_whiteness(gaussian(n, 1, 8), every_sample(n), 100.0, 50.0);
  CHECK(pure.peak_fraction == Approx(0.2).margin(0.02));  // top twentieth of exponentials: (1 + ln 20) / 20
  CHECK(judged.peak_fraction > pure.peak_fraction + 0.02);
}

TEST_CASE("a residual that is white up to the filter's band edge passes within that band", "[ident][metrics]") {
  VectorXd smooth = gaussian(6000, 1, 9);
  VectorXd filtered = smooth;
  for (Index i = 4; i < 5996; ++i) filtered(i) = smooth.segment(i - 4, 9).mean();  // low-pass: nothing beyond 11 Hz
  CHECK_FALSE(ident::residual_whiteness(filtered, every_sample(6000), 100.0, 50.0).white);
  CHECK(ident::residual_whiteness(filtered, every_sample(6000), 100.0, 1.5).white);
}

TEST_CASE("gaps between the rows are neither structure nor evidence", "[ident][metrics]") {
  // Rows gated by a motion of 2 Hz, as `where = "abs(v) > ..."` leaves them.
  const Index n = 4000;
  std::vector<Index> rows;
  for (Index i = 0; i < n; ++i)
    if (std::abs(std::sin(2.0 * std::numbers::pi * 2.0 * static_cast<double>(i) / 100.0)) > 0.7) rows.push_back(i);
  const auto count = static_cast<Index>(rows.size());
  REQUIRE(5 * count < 3 * n);
  // Noise that is white within the band of 10 Hz and nothing beyond. Rows laid end to end would show the gate.
  const auto band_limited = [&](unsigned seed) {
    const VectorXd shocks = gaussian(n + 40, 1, seed);
    VectorXd noise(n);
    for (Index i = 0; i < n; ++i) {
      noise(i) = 0.2 * shocks(i + 20);
      for (Index k = 1; k <= 20; ++k) {
        const double w = 0.5 * (1.0 + std::cos(std::numbers::pi * static_cast<double>(k) / 21.0));
        noise(i) += w * std::sin(0.2 * std::numbers::pi * static_cast<double>(k)) /
                    (std::numbers::pi * static_cast<double>(k)) * (shocks(i + 20 - k) + shocks(i + 20 + k));
      }
    }
    return noise;
  };
  int refused = 0, tones_seen = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    VectorXd noise = band_limited(seed)(rows);
    refused += !ident::residual_whiteness(noise, rows, 100.0, 6.0).white;
    for (Index i = 0; i < count; ++i)
      noise(i) +=
          0.4 * std::sin(2.0 * std::numbers::pi * 3.3 * static_cast<double>(rows[static_cast<std::size_t>(i)]) / 100.0);
    tones_seen += !ident::residual_whiteness(noise, rows, 100.0, 6.0).white;
  }
  CHECK(refused <= 5);  // expected 1 at the level of 0.01, four standard deviations more
  CHECK(tones_seen == 100);
  CHECK_THROWS_AS(ident::residual_whiteness(VectorXd::Ones(count), every_sample(n), 100.0, 6.0), std::invalid_argument);
}

TEST_CASE("too little to test is said, not guessed", "[ident][metrics]") {
  CHECK_FALSE(ident::residual_whiteness(gaussian(20, 1, 1), every_sample(20), 100.0, 50.0).tested);
  CHECK_FALSE(ident::residual_whiteness(VectorXd::Constant(500, 0.1), every_sample(500), 100.0, 50.0).tested);
  CHECK_FALSE(ident::residual_whiteness(VectorXd::Zero(500), every_sample(500), 100.0, 50.0).tested);
}

TEST_CASE("block scores do not depend on the pieces in which rows come", "[ident][metrics]") {
  const Index n = 1003;
  const MatrixXd phi = gaussian(n, 2, 7);
  const VectorXd residual = gaussian(n, 1, 8);
  ident::BlockScores pieces(2, n);
  for (Index first = 0; first < n; first += 17)
    pieces.add(phi.middleRows(first, std::min<Index>(17, n - first)),
               residual.segment(first, std::min<Index>(17, n - first)));
  MatrixXd direct(2, 50);
  for (Index block = 0; block < 50; ++block) {
    const Index first = block * n / 50, count = (block + 1) * n / 50 - first;
    direct.col(block) = phi.middleRows(first, count).transpose() * residual.segment(first, count);
  }
  // Sums of some twenty products of order one, added in another order.
  CHECK((pieces.sums() - direct).cwiseAbs().maxCoeff() <= 1e-13);
}

TEST_CASE("robust standard deviations are right where the residual is coloured and where it is not",
          "[ident][metrics]") {
  for (const double memory : {0.0, 0.9}) {
    double promised = 0.0, plain = 0.0, happened = 0.0;
    constexpr int draws = 300;
    for (unsigned seed = 0; seed < draws; ++seed) {
      // Slowly varying column and AR(1) noise: the classical standard deviation is far too small for memory 0.9.
      const Index n = 2000;
      MatrixXd phi(n, 1);
      VectorXd noise = gaussian(n, 1, 100 + seed), shock = gaussian(n, 1, 5000 + seed);
      phi(0, 0) = shock(0);
      for (Index i = 1; i < n; ++i) {
        phi(i, 0) = 0.9 * phi(i - 1, 0) + shock(i);
        noise(i) += memory * noise(i - 1);
      }
      const auto data = ident::r_factor(phi, 2.0 * phi + noise);
      const auto fit = ident::fit_ols(data);
      const VectorXd residual = 2.0 * phi.col(0) + noise - phi.col(0) * fit.mean(0);
      ident::BlockScores scores(1, n);
      for (const Index first : {0, 700, 1400})  // as rows come by, in pieces that are no blocks
        scores.add(phi.middleRows(first, std::min<Index>(700, n - first)),
                   residual.segment(first, std::min<Index>(700, n - first)));
      promised += ident::robust_covariance(data, scores)(0, 0) / draws;
      plain += fit.covariance(0, 0) / draws;
      happened += std::pow(fit.mean(0) - 2.0, 2) / draws;
    }
    // A variance from 300 draws is known to 8 %; blocks of 40 rows cut some of the memory.
    CHECK(promised == Approx(happened).epsilon(0.35));
    if (memory > 0.0) CHECK(plain < 0.3 * happened);
  }
}

TEST_CASE("errors and whiteness do not depend on the unit, however small or large", "[ident][judge]") {
  const VectorXd actual = gaussian(500, 1, 3), predicted = actual + 0.1 * gaussian(500, 1, 4);
  const auto whiteness = ident::residual_whiteness(actual - predicted, every_sample(500), 100.0, 40.0);
  REQUIRE(whiteness.tested);
  for (const int exponent : {-1000, -600, 600, 1000}) {
    CAPTURE(exponent);
    const double unit = std::ldexp(1.0, exponent);
    CHECK(ident::nmse(unit * predicted, unit * actual) == Approx(ident::nmse(predicted, actual)).epsilon(1e-12));
    CHECK(ident::nmse_centred(unit * predicted, unit * actual) ==
          Approx(ident::nmse_centred(predicted, actual)).epsilon(1e-12));
    const auto scaled = ident::residual_whiteness(unit * (actual - predicted), every_sample(500), 100.0, 40.0);
    CHECK(scaled.tested);
    CHECK(scaled.p_value == Approx(whiteness.p_value).epsilon(1e-9));
  }
}
