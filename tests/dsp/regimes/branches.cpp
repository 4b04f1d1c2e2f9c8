#include "dsp/regimes/branches.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "dsp/regimes/switching_model.hpp"

namespace test_regimes_branches {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double rate_hz = 256.0;
constexpr Index samples_per_half = 80;

/// Half cycles whose amplitude changes between one and 1.5 with this probability, each with a scatter of its own.
std::vector<dsp::HalfCycle> switching_halves(Index count, double switch_probability, double scatter, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> even(0.0, 1.0);
  std::normal_distribution<double> normal(0.0, scatter);
  bool upper = false;
  std::vector<dsp::HalfCycle> halves;
  for (Index k = 0; k < count; ++k) {
    if (even(engine) < switch_probability) upper = !upper;
    const Index first = k * samples_per_half;
    halves.push_back({.first = first,
                      .middle = first + samples_per_half / 2,
                      .last = first + samples_per_half,
                      .amplitude = (upper ? 1.5 : 1.0) * std::exp(normal(engine))});
  }
  return halves;
}

/// The states where the probability of a switch is what the states under it say that it is, found by halving.
dsp::StateSequence settled(const std::vector<dsp::HalfCycle>& halves, double high_amplitude) {
  const auto count = static_cast<Index>(halves.size());
  VectorXd level(count);
  for (Index k = 0; k < count; ++k) level(k) = std::log(halves[static_cast<std::size_t>(k)].amplitude / high_amplitude);
  const double spread =
      std::sqrt((level.tail(count - 1) - level.head(count - 1)).squaredNorm() / static_cast<double>(count - 1));
  Eigen::MatrixX2d likelihoods(count, 2);
  likelihoods << -level / spread, level / spread;
  std::vector<bool> anew(halves.size(), false);
  anew[0] = true;
  const auto states = [&](double p) { return dsp::most_probable_states(likelihoods, anew, p); };
  double low = 1e-6, high = 0.5;
  for (int i = 0; i < 60; ++i) {
    const double p = 0.5 * (low + high);
    (dsp::probability_of(states(p).expected_switches, static_cast<double>(count)) > p ? low : high) = p;
  }
  return states(low);
}

}  // namespace

TEST_CASE("branches by amplitude are those at which the probability of a switch has settled", "[dsp][regimes]") {
  const double high_amplitude = std::sqrt(1.5);
  for (const double switch_probability : {0.01, 0.05, 0.15})
    for (unsigned seed = 1; seed <= 5; ++seed) {
      INFO("probability " << switch_probability << ", seed " << seed);
      const auto halves = switching_halves(600, switch_probability, 0.05, seed);
      const auto expected = settled(halves, high_amplitude);
      const auto found = dsp::branches_by_amplitude(halves, high_amplitude, rate_hz).intervals;
      std::size_t interval = 0;
      for (std::size_t k = 0; k < halves.size(); ++k) {
        while (interval + 1 < found.size() && found[interval + 1].first <= halves[k].middle) ++interval;
        CHECK(found[interval].upper == (expected.states[k] == 1));
      }
      CHECK(interval + 1 == found.size());
    }
}

}  // namespace test_regimes_branches
