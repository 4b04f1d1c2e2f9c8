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
      "[[range]]\nname = \"mixed\"\nfrom = 0\nto = 1720\ntrain_to = 1000\n");
  const auto ended = support::run(folder, "$ARDENT -q run qzs.toml -o matched");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
  const json metrics = json::parse(support::bytes_of(folder / "matched/metrics.json"));
  const json low = range_of(metrics, "low"), high = range_of(metrics, "high"), mixed = range_of(metrics, "mixed");
  CHECK(nmse(low, "train") <= 3e-6);
  CHECK(nmse(low, "test") <= 4e-6);
  CHECK(nmse(mixed, "train") <= 6e-6);
  CHECK(nmse(mixed, "test") <= 2e-5);
  for (const json& fit : {low, high}) CHECK(nmse(fit, "free_run") <= 2e-4);

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
