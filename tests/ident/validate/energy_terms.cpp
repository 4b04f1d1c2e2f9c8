#include "ident/validate/energy_terms.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using ident::is_damping;
using ident::is_dry_friction;

TEST_CASE("damping is what is odd in the speed, whatever x is", "[ident][energy]") {
  for (const char* term : {"v", "v^3", "x^2*v", "abs(v)*v", "sgn(v)", "abs(x)*v", "dy", "sgn(dy)"})
    CHECK(is_damping(term));
  for (const char* term : {"x", "x*v", "v^2", "x*v^2", "1", "f", "f*v", "abs(v)", "z"}) CHECK_FALSE(is_damping(term));
  for (const char* term : {"sgn(v)", "sgn(dy)", "abs(x)*sgn(v)"}) CHECK(is_dry_friction(term));
  for (const char* term : {"v", "abs(v)*v", "x^2*v", "x"}) CHECK_FALSE(is_dry_friction(term));
}

TEST_CASE("what feeds energy is told from what takes it by the sign of its coefficient, beyond its interval",
          "[ident][energy]") {
  ident::Model model;
  model.target = "a";
  model.terms = {{.name = "x", .mean = -50.0, .std = 0.1},
                 {.name = "v", .mean = -0.8, .std = 0.1},
                 {.name = "v^3", .mean = 0.3, .std = 0.1}};
  CHECK(ident::energy_terms(model).take == std::vector<std::string>{"v"});
  CHECK(ident::energy_terms(model).feed == std::vector<std::string>{"v^3"});
  CHECK_FALSE(ident::energy_terms(model).friction_feeds);
  model.terms[2].std = 0.2;
  CHECK(ident::energy_terms(model).feed.empty());
  model.terms[2] = {.name = "sgn(v)", .mean = 0.3, .std = 0.1};
  CHECK(ident::energy_terms(model).friction_feeds);
  model.target = "f";  // of a force law the signs are the other way round, and depend on what it is
  CHECK(ident::energy_terms(model).feed.empty());
}

TEST_CASE("the loss per cycle is that of the envelope", "[ident][energy]") {
  std::vector<double> crests, steady;
  for (int i = 0; i < 40; ++i) {
    const double ripple = 1.0 + 0.002 * std::cos(2.4 * i);
    crests.push_back(std::pow(0.97, i) * ripple), steady.push_back(ripple);
  }
  const auto loss = ident::loss_per_cycle({crests, {1.0, 0.5}}, 1e-3);
  REQUIRE(loss.has_value());
  CHECK(std::abs(loss->mean - 0.03) < 3.0 * loss->std);
  CHECK(loss->std < 2e-4);
  CHECK(loss->falls());
  CHECK_FALSE(ident::loss_per_cycle({steady}, 1e-3)->falls());
  std::vector<double> settles(20, 1.0);  // above its limit cycle at first
  for (std::size_t i = 0; i < settles.size(); ++i) settles[i] = steady[i] + std::pow(0.5, static_cast<double>(i));
  CHECK_FALSE(ident::loss_per_cycle({settles}, 1e-3)->falls());
  CHECK_FALSE(ident::loss_per_cycle({crests}, 0.95).has_value());  // two of them are so large
}
