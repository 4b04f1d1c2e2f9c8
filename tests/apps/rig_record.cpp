// The rig's raw record, simulated, through the whole program: the bars that its recipe was built for.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "support/program.hpp"

using nlohmann::json;
using support::Scratch;

namespace {

json range_of(const json& metrics, const std::string& name) {
  for (const auto& range : metrics["ranges"])
    if (range["name"] == name) return range["methods"][0];
  FAIL("no range " << name);
  return {};
}

double nmse(const json& fit, const char* which) {
  return fit["nmse"][which].get<double>();
}

}  // namespace

TEST_CASE("half an hour of raw record gives friction and damping to a per cent", "[apps][rig]") {
  const Scratch folder;
  REQUIRE(support::run(folder, "$ARDENT -q sim qzs --raw -o rig --seed 1").code == 0);
  (void)folder.file(
      "qzs.toml",
      "schema = 1\n[[recording]]\nfile = \"rig/recording.wav\"\n[prepare]\nrate_hz = 25.6\ncutoff_hz = "
      "10.24\nrolloff_hz = 8\n"
      "[library]\norder = 0\nterms = [\"x\", \"v\", \"x^3\", \"sgn(v)\", \"ddr\"]\n[fit]\nmethods = [\"fast_rvm\"]\n"
      "[[range]]\nname = \"low\"\nfrom = 2.9\nto = 830\ntrain_to = 500\n"
      "[[range]]\nname = \"high\"\nfrom = 1440\nto = 1720\ntrain_to = 1560\n"
      "[[range]]\nname = \"middle\"\nfrom = 2.9\nto = 1390\ntrain_to = 1000\n"
      "[[range]]\nname = \"mixed\"\nfrom = 0\nto = 1720\ntrain_to = 1000\n");
  const auto ended = support::run(folder, "$ARDENT -q run qzs.toml -o matched");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
  const json metrics = json::parse(support::bytes_of(folder / "matched/metrics.json"));
  const json low = range_of(metrics, "low"), high = range_of(metrics, "high"), middle = range_of(metrics, "middle"),
             mixed = range_of(metrics, "mixed");
  CHECK(nmse(low, "train") <= 3e-6);
  CHECK(nmse(low, "test") <= 4e-6);
  CHECK(nmse(mixed, "train") <= 6e-6);
  CHECK(nmse(mixed, "test") <= 2e-5);
  for (const json& fit : {low, high, middle}) CHECK(nmse(fit, "free_run") <= 2e-4);

  std::map<std::string, double> found;
  for (const auto& term : mixed["terms"]) found[term["name"]] = term["mean"];
  const double laser = 0.996;  // gain of the payload's laser, in whose units stiffnesses are found
  CHECK(found["x"] == Approx(-50.0).epsilon(0.01));
  CHECK(found["v"] == Approx(-0.8).epsilon(0.01));
  CHECK(found["x^3"] == Approx(-95000.0 / (laser * laser)).epsilon(0.01));
  CHECK(found["sgn(v)"] == Approx(-0.08).epsilon(0.02));
  CHECK(found["ddr"] == Approx(-1.0).epsilon(0.01));

  // The recipe taken literally: a one-step error below half a per cent, and damping wrong by a factor of three.
  const auto paper = support::run(folder, "$ARDENT -q run qzs.toml -o paper --set prepare.recipe=paper");
  REQUIRE(paper.code == 0);
  const json literal = range_of(json::parse(support::bytes_of(folder / "paper/metrics.json")), "mixed");
  CHECK(nmse(literal, "train") < 5e-3);
  CHECK(nmse(literal, "free_run") > 0.1);
  for (const auto& term : literal["terms"])
    if (term["name"] == "v") CHECK(term["mean"].get<double>() < -2.4);
}

TEST_CASE("free decays of the payload give spring, damping and friction where filters do not reach the hand",
          "[apps][rig][decay]") {
  const Scratch folder;
  REQUIRE(support::run(folder, "$ARDENT -q sim qzs --raw --programme decay -o decay").code == 0);
  const std::string run = "$ARDENT run decay/recording.wav --set 'fit.methods=[\"fast_rvm\"]' ";
  // At 25.6 Hz their reach is longer than any decay.
  const auto narrow = support::run(folder, run + "-o narrow --set prepare.rate_hz=25.6 --set prepare.cutoff_hz=10.24");
  CHECK(narrow.code == 0);
  CHECK_THAT(narrow.err, Catch::Contains("[regime.no_motion]"));
  const auto wide = support::run(
      folder,
      run +
          "-o wide --set prepare.rate_hz=256 --set prepare.cutoff_hz=30 --set prepare.acceleration=displacement "
          "--set prepare.zero=none --set fit.train_share=0.8 --set library.order=0 "
          "--set 'library.terms=[\"1\",\"x\",\"v\",\"x^2\",\"x^3\",\"sgn(v)\"]'");
  CAPTURE(wide.err);
  REQUIRE(wide.code == 0);
  CHECK_THAT(wide.err, !Catch::Contains("[regime.no_motion]"));
  std::map<std::string, double> found;
  const json fit = range_of(json::parse(support::bytes_of(folder / "wide/metrics.json")), "low");
  for (const auto& term : fit["terms"]) found[term["name"]] = term["mean"];
  // About the lasers' zero, 1.9 mm off: k1 + 3 k3 z^2 etc. A decay of 1.5 s hardly distinguishes friction from damping.
  const double k3 = 95000.0 / (0.996 * 0.996), zero_m = 1.9e-3;
  CHECK(found["x"] == Approx(-50.0 - 3.0 * k3 * zero_m * zero_m).epsilon(0.01));
  CHECK(found["x^2"] == Approx(-3.0 * k3 * zero_m).epsilon(0.05));
  CHECK(found["x^3"] == Approx(-k3).epsilon(0.02));
  CHECK(found["v"] == Approx(-0.8).epsilon(0.10));
  CHECK(found["sgn(v)"] == Approx(-0.08).epsilon(0.05));
}
