#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "apps/paper/section4.hpp"
#include "ident/selection/ranked_models.hpp"
#include "sim/noise.hpp"

using Eigen::Index;

// The acceleration of the paper's Coulomb case at 10 % noise, where the estimate of its friction is 2.2 standard errors
// large, with the friction taken out of every second draw.
TEST_CASE("of the terms that are given a probability, so many are true", "[apps][paper][inclusion]") {
  const apps::Section4Study study = apps::section4_study(*apps::find_section4_case("coulomb"));
  const apps::Section4Regression& regression = study.regressions.front();
  const apps::Section4Row& row = regression.rows[1];
  const auto& terms = study.library.terms;
  const Index friction =
      std::find_if(terms.begin(), terms.end(), [](const auto& t) { return t.name == "sgn(v)"; }) - terms.begin();
  constexpr int num_bins = 5, num_draws = 800;
  double counts[num_bins] = {}, predicted[num_bins] = {}, present[num_bins] = {};
  double of_friction[2] = {};
  for (int draw = 0; draw < num_draws; ++draw) {
    const bool has_friction = draw % 2 == 0;
    Eigen::VectorXd target = row.values;
    if (!has_friction) target -= row.truth(friction) * regression.phi.col(friction);
    const sim::Noise noise(static_cast<std::uint64_t>(draw), 77);
    for (Index i = 0; i < target.size(); ++i) target(i) += 0.1 * row.std * noise.normal(static_cast<std::uint64_t>(i));
    const auto ranking = ident::ranked_models(ident::unit_problem(ident::r_factor(regression.phi, target)), {});
    of_friction[has_friction ? 1 : 0] += ranking.inclusion(friction) / (num_draws / 2);
    for (Index i = 0; i < ranking.inclusion.size(); ++i) {
      const int bin = std::min(num_bins - 1, static_cast<int>(num_bins * ranking.inclusion(i)));
      ++counts[bin];
      predicted[bin] += ranking.inclusion(i);
      present[bin] += row.truth(i) != 0.0 && (i != friction || has_friction) ? 1.0 : 0.0;
    }
  }
  CHECK(of_friction[1] > of_friction[0]);
  for (int bin = 0; bin < num_bins; ++bin) {
    CAPTURE(bin, counts[bin], predicted[bin], present[bin]);
    REQUIRE(counts[bin] >= 50);  // of fewer, chance moves the share of true ones by more than 0.07
    CHECK(std::abs(present[bin] - predicted[bin]) <= 0.1 * counts[bin]);
  }
}
