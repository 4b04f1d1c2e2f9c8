#include "dsp/regimes/regime.hpp"

#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>

using dsp::Regime;
using dsp::RegimeSet;

TEST_CASE("regimes and sets of them go through their names and back", "[dsp][regime]") {
  for (const dsp::RegimeInfo& known : dsp::regime_table()) CHECK(dsp::regime_from_string(known.name) == known.regime);
  for (const std::string& name : dsp::regime_set_names()) CHECK(dsp::regime_set_from_string(name).name() == name);
  CHECK_THROWS_WITH(dsp::regime_set_from_string("middle"), Catch::Contains("low") && Catch::Contains("middle"));
}

TEST_CASE("mixed holds the regimes of motion, and no name at all holds everything", "[dsp][regime]") {
  for (const dsp::RegimeInfo& known : dsp::regime_table()) {
    CHECK(RegimeSet::mixed().holds(known.regime) == known.moving);
    CHECK(RegimeSet().holds(known.regime));
    CHECK(RegimeSet(known.regime).holds(known.regime));
  }
}

TEST_CASE("sets meet where they share a regime", "[dsp][regime]") {
  CHECK(RegimeSet::mixed().meets(Regime::low));
  CHECK_FALSE(RegimeSet::mixed().meets(Regime::stick));
  CHECK_FALSE(RegimeSet(Regime::low).meets(Regime::high));
  CHECK(RegimeSet().meets(Regime::stick));
}
