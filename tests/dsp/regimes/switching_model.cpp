#include "dsp/regimes/switching_model.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/signals.hpp"

using Eigen::Index;

TEST_CASE("states of a switching model are those of all sequences, one by one", "[dsp][switching_model]") {
  constexpr Index count = 9;
  constexpr double chance = 0.2;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Eigen::MatrixX2d told(count, 2);
    told << support::gaussian(count, seed, 1.0), support::gaussian(count, seed + 100, 1.0);
    std::vector<bool> anew(count, false);
    anew[0] = anew[5] = true;
    double total = 0.0, best = -1.0;
    Eigen::VectorXd upper = Eigen::VectorXd::Zero(count), changes = upper;
    std::vector<int> likeliest;
    for (unsigned code = 0; code < 1U << count; ++code) {
      std::vector<int> states;
      double joint = 1.0;
      for (Index k = 0; k < count; ++k) {
        states.push_back(static_cast<int>(code >> k & 1U));
        joint *= std::exp(told(k, states.back()));
        if (k > 0)
          joint *= anew[static_cast<std::size_t>(k)]          ? 0.5
                   : states.rbegin()[0] == states.rbegin()[1] ? 1 - chance
                                                              : chance;
      }
      total += joint;
      for (Index k = 0; k < count; ++k) {
        const auto at = static_cast<std::size_t>(k);
        if (states[at] == 1) upper(k) += joint;
        if (k > 0 && states[at] != states[at - 1]) changes(k) += joint;
      }
      if (joint > best) best = joint, likeliest = states;
    }
    const dsp::StateSequence found = dsp::most_probable_states(told, anew, chance);
    CHECK(found.states == likeliest);
    CHECK(found.probability.isApprox(upper / total, 1e-12));
    CHECK(found.switch_probability.isApprox(changes / total, 1e-12));
    CHECK(found.expected_switches == Approx((changes.sum() - changes(5)) / total));
  }
}
