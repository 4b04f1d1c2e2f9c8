#include "dsp/regimes/reversals.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>

#include "dsp/regimes/halt_rows.hpp"
#include "support/signals.hpp"

namespace test_regimes_reversals {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 256.0, half_s = 0.4;
constexpr Index period = 205;
constexpr int finer = 32;  // a leap lies between samples: each is the mean of so many

struct Course {
  VectorXd v, a;
  std::vector<double> leaps_s;  ///< where half waves end
};

// Half sines of v at 1.25 Hz to and fro; friction makes the acceleration leap from 0.55 to 0.3 m/s^2 at each end, and
// after half wave k the payload rests for halt_s(k).
Course course(const std::function<double(int)>& halt_s, double noise, unsigned seed) {
  const auto n = static_cast<Index>(120.0 * rate_hz);
  Course result{support::gaussian(n, seed + 100, 1e-4), support::gaussian(n, seed, noise), {}};
  double begin_s = 0.0, end_s = half_s, sign = 1.0;
  int number = 0;
  for (Index i = 0; i < n; ++i)
    for (int part = 0; part < finer; ++part) {
      const double t = (static_cast<double>(i) + (part + 0.5) / finer - 0.5) / rate_hz;
      if (t >= end_s) {
        result.leaps_s.push_back(end_s);
        begin_s = end_s + halt_s(number++);
        end_s = begin_s + half_s;
        sign = -sign;
      }
      if (t < begin_s) continue;
      const double phase = std::numbers::pi * (t - begin_s) / half_s;
      result.a(i) += sign * (0.425 * std::cos(phase) - 0.125) / finer;
      result.v(i) += sign * 0.425 * std::sin(phase) * half_s / std::numbers::pi / finer;  // only its sign counts
    }
  return result;
}

/// halt_s is 0 where none is told.
std::vector<dsp::Reversal> reversals(const Course& c, double cutoff_hz = 32.0) {
  auto found =
      dsp::reversals(dsp::sign_changes(c.v, period), c.v, c.a, {.sample_rate_hz = rate_hz, .cutoff_hz = cutoff_hz});
  VectorXd log_ratios(static_cast<Index>(found.size()));
  for (Index k = 0; k < log_ratios.size(); ++k) log_ratios(k) = found[static_cast<std::size_t>(k)].log_ratio;
  const VectorXd halts = dsp::halt_probabilities(log_ratios);
  for (Index k = 0; k < halts.size(); ++k)
    if (halts(k) <= 0.5) found[static_cast<std::size_t>(k)].halt_s = 0.0;
  return found;
}

}  // namespace

TEST_CASE("plain reversals are no halts, however noisy", "[dsp][reversals]") {
  for (const double noise : {0.0, 0.002, 0.005, 0.02}) {
    INFO("noise " << noise);
    const auto found = reversals(course([](int) { return 0.0; }, noise, 11));
    CHECK(found.size() > 280);
    CHECK(std::none_of(found.begin(), found.end(), [](const auto& r) { return r.halt_s > 0.0; }));
  }
}

TEST_CASE("halts shorter than a sample are found among plain reversals, with their length", "[dsp][reversals]") {
  for (const double halt_s : {0.0025, 0.006, 0.012, 0.02}) {
    INFO("halts of " << halt_s << " s");
    // Three in a row of every thirty.
    const Course c = course([&](int k) { return k % 30 < 3 ? halt_s : 0.0; }, 0.0005, 12);
    const auto found = reversals(c);
    int halts = 0;
    for (std::size_t k = 0; k < c.leaps_s.size(); ++k) {
      const auto at = std::find_if(found.begin(), found.end(), [&](const auto& r) {
        return std::abs(static_cast<double>(r.at) / rate_hz - c.leaps_s[k]) < 0.03;
      });
      if (c.leaps_s[k] < 1.0 || c.leaps_s[k] > 119.0) continue;  // at the ends of the record
      CHECK((at != found.end() && at->halt_s > 0.0) == (k % 30 < 3));
      // The grid of halts is as fine as 2 ms at its short end and 5 ms at the other.
      if (k % 30 >= 3 || at == found.end()) continue;
      CHECK(at->halt_s == Approx(halt_s).margin(0.003));
      ++halts;
    }
    CHECK(halts > 25);
  }
}

TEST_CASE("short halts are told at any cut-off", "[dsp][reversals]") {
  const Course c = course([](int k) { return k % 30 < 3 ? 0.0025 : 0.0; }, 0.0002, 16);
  for (const double cutoff_hz : {30.0, 32.5, 34.4, 37.9, 38.0}) {
    INFO(cutoff_hz);
    const auto found = reversals(c, cutoff_hz);
    CHECK(std::count_if(found.begin(), found.end(), [](const auto& r) { return r.halt_s > 0.0; }) > 20);
  }
}

TEST_CASE("a halt alone must be clear", "[dsp][reversals]") {
  const auto halts_seen = [](double halt_s, double noise) {
    const auto found = reversals(course([&](int k) { return k % 31 == 0 ? halt_s : 0.0; }, noise, 13));
    return std::count_if(found.begin(), found.end(), [](const auto& r) { return r.halt_s > 0.0; });
  };
  CHECK(halts_seen(0.012, 0.0005) >= 9);
  CHECK(halts_seen(0.001, 0.01) == 0);
}

TEST_CASE("reversals that cannot be seen are left out", "[dsp][reversals]") {
  const VectorXd v = VectorXd::Ones(500), a = VectorXd::Zero(500);
  CHECK(dsp::sign_changes(v, 100).empty());
  CHECK(dsp::reversals({}, v, a, {.sample_rate_hz = rate_hz, .cutoff_hz = 32.0}).empty());
}

TEST_CASE("changes of sign close together are one reversal or none", "[dsp][reversals]") {
  VectorXd v = VectorXd::NullaryExpr(
      980, [](Index i) { return std::cos(std::numbers::pi * (static_cast<double>(i) + 0.5) / 100.0); });
  const auto plain = dsp::sign_changes(v, 200);
  CHECK(plain == std::vector<Index>{50, 150, 250, 350, 450, 550, 650, 750, 850});  // the last is too near the end
  v(353) *= -1.0;                                                                  // back again, and over for good
  v(610) *= -1.0;                                                                  // a touch of zero, and no reversal
  CHECK(dsp::sign_changes(v, 200) == plain);
  v(480) *= -1.0;  // too close to 450 for either to be detected
  CHECK(dsp::sign_changes(v, 200).size() == plain.size() - 1);
}

}  // namespace test_regimes_reversals
