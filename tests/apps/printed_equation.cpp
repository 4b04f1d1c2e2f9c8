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
  SECTION("two recordings, one of which rests elsewhere") {
    for (const char* seed : {"7", "8"})
      REQUIRE(run(folder, std::string("$ARDENT -q sim duffing --noise 0.01 --seed ") + seed + " -o sim" + seed).code ==
              0);
    (void)folder.file("both.toml",
                      "schema = 1\n[[recording]]\nfile = \"sim7/response.csv\"\n[[recording]]\nfile = "
                      "\"sim8/response.csv\"\n[[range]]\nname = \"all\"\n");
    reaches_claim("$ARDENT -q run both.toml -o both", "both");
  }
}

TEST_CASE("the printed equation predicts the last tenth of an electronic oscillator", "[apps][measured]") {
  const auto record = std::filesystem::path(ARDENT_REAL_DATA) / "silverbox_multisine/snls80mv_rows_40496_118723.csv";
  if (!std::filesystem::exists(record)) {
    WARN("skipped: no file " << record);
    return;
  }
  const support::Scratch folder;
  (void)folder.file("side.toml",
                    "schema = 1\nrate = 610.3515625\n[[channel]]\nname = \"input\"\ncolumn = \"V1\"\nrole = \"f\"\n"
                    "unit = \"V\"\n[[channel]]\nname = \"output\"\ncolumn = \"V2\"\nrole = \"y\"\nunit = \"V\"\n");
  REQUIRE(run(folder, "$ARDENT -q run " + record.string() + " --sidecar side.toml -o box").code == 0);
  // Least squares with x^2 and x^3 leave 0.46 mV.
  CHECK(support::printed_rms(folder / "box", 0.1) <= 0.45e-3);
}
