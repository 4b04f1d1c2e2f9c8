#include "support/printed_equation.hpp"

#include <catch2/catch.hpp>

#include "support/program.hpp"
#include "support/scratch.hpp"

using support::run;

TEST_CASE("the printed equation, run by an integrator of the tests, follows the record as closely as is claimed",
          "[apps][printed_equation]") {
  const support::Scratch folder;
  const auto reaches_claim = [&](const std::string& command, const std::string& results) {
    CAPTURE(command);
    REQUIRE(run(folder, command).code == 0);
    const support::PrintedRun found = support::printed_run(folder / results);
    REQUIRE(found.why_not == "");
    CHECK(found.claimed > 0.0);
    support::check_printed_equation(folder / results);
  };
  SECTION("friction, a base, four sensors and a zero that the fit finds") {
    reaches_claim(std::string("$ARDENT -q run ") + ARDENT_DATA + "/qzs_256.flac -o rig", "rig");
  }
  SECTION("a driven cubic spring, noise on its sensors") {
    REQUIRE(run(folder, "$ARDENT -q sim duffing --noise 0.01 --seed 5 -o sim").code == 0);
    reaches_claim("$ARDENT -q run sim/response.csv -o duffing", "duffing");
  }
  SECTION("friction alone, a force") {
    REQUIRE(run(folder, "$ARDENT -q sim coulomb --noise 0.01 --seed 6 -o sim").code == 0);
    reaches_claim("$ARDENT -q run sim/response.csv -o coulomb", "coulomb");
  }
}
