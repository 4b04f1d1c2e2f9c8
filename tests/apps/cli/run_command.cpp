#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>

#include "support/program.hpp"
#include "support/turned_force_record.hpp"

using nlohmann::json;
using support::Scratch;

TEST_CASE("the report and quality.json name what a sidecar gets wrong", "[apps][run_command]") {
  const Scratch folder;
  const std::string recording = std::string(ARDENT_DATA) + "/qzs_256.flac";
  std::string side = support::bytes_of(recording + ".toml");
  const auto at = side.rfind("100 mV/g");  // the payload's accelerometer, said to be the other way round
  side.insert(at + 9, "\nsign = -1");
  (void)folder.file("side.toml", side);
  (void)folder.file("run.toml", "schema = 1\n[[recording]]\nfile = \"" + recording +
                                    "\"\nsidecar = \"side.toml\"\n[prepare]\nrate_hz = 25.6\ncutoff_hz = 10.24\n"
                                    "[library]\norder = 1\n[fit]\nmethods = [\"ols\"]\n");
  const auto ended = support::run(folder, "$ARDENT run run.toml -o run");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
  CHECK_THAT(ended.err, Catch::Contains("[sensor.polarity]"));
  const auto report = support::bytes_of(folder / "run/equation.txt");
  CHECK_THAT(report, Catch::Contains("opposite signs") && Catch::Contains("sign = 1"));
  const json quality = json::parse(support::bytes_of(folder / "run/quality.json"));
  CHECK(quality["pairs"][1]["gain"].get<double>() == Approx(-0.989).margin(2e-3));
}

TEST_CASE("a rig inside the library is described, one with physics outside it is not", "[apps][run_command][rig]") {
  const Scratch folder;
  const auto words = [&](const std::string& twin) {
    const auto made = support::run(
        folder, "$ARDENT -q sim qzs --raw --rate 256 --container flac --twin " + twin + " --duration 900 -o " + twin);
    REQUIRE(made.code == 0);
    const auto ended = support::run(
        folder, "$ARDENT -q run " + twin + "/recording.flac -o " + twin +
                    "-run --set prepare.rate_hz=25.6 --set prepare.cutoff_hz=10.24 --set library.order=0 --set "
                    "'library.terms=[\"x\",\"v\",\"x^3\",\"sgn(v)\",\"ddr\"]' --set 'fit.methods=[\"fast_rvm\"]'");
    CAPTURE(ended.err);
    REQUIRE(ended.code == 0);
    return json::parse(support::bytes_of(folder / (twin + "-run/equation.json")))["ranges"][0]["methods"][0];
  };
  const json inside = words("T0"), outside = words("T1");
  CHECK(inside["verdict"] == "describes");
  CHECK(outside["verdict"] != "describes");
  CHECK_THAT(outside["sentence"].get<std::string>(), Catch::Contains("more than the noise of the signals"));
  CHECK(outside["cause"] == "missing_term");
}

TEST_CASE("the shipped record has the terms of its truth, and none that is improbable", "[apps][run_command][rig]") {
  const Scratch folder;
  const auto ended =
      support::run(folder, "$ARDENT -q run " ARDENT_DATA "/qzs_256.flac -o run --set 'fit.methods=[\"fast_rvm\"]'");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
  CHECK_THAT(ended.out, Catch::Contains("From range mixed"));
  const json metrics = json::parse(support::bytes_of(folder / "run/metrics.json"));
  for (const json& range : metrics.at("ranges")) {
    std::set<std::string> names;
    for (const json& term : range["methods"][0]["terms"]) {
      CAPTURE(range["name"], term["name"]);
      CHECK(term["inclusion_probability"].get<double>() > 0.5);
      names.insert(term["name"]);
    }
    if (range["name"] == "mixed") CHECK(names == std::set<std::string>{"x", "v", "x^3", "sgn(v)", "ddr"});
  }
}

TEST_CASE("an open band ends where one equation holds, a given one where it was asked to", "[apps][run_command]") {
  const Scratch folder;
  const dsp::Recording recording = support::turned_force_record(1.5);
  std::string csv = "t_s,x_m,f_N\n";
  for (Eigen::Index i = 0; i < recording.samples.rows(); ++i)
    csv += fmt::format("{:.9g},{:.9g},{:.9g}\n", static_cast<double>(i) / recording.sample_rate_hz,
                       recording.samples(i, 0), recording.samples(i, 1));
  (void)folder.file("duffing.csv", csv);
  const auto equation_of = [&](const std::string& more) {
    const auto ended = support::run(
        folder, fmt::format("$ARDENT -q run duffing.csv -o run --force --set 'fit.methods=[\"fast_rvm\"]' {}", more));
    CAPTURE(ended.err);
    REQUIRE(ended.code == 0);
    const json equation = json::parse(support::bytes_of(folder / "run/equation.json"));
    std::map<std::string, std::pair<double, double>> terms;  // mean and standard deviation
    for (const json& term : equation["ranges"][0]["methods"][0]["terms"])
      terms[term["name"]] = {term["mean"], term["std"]};
    return terms;
  };
  const auto given = equation_of("--set prepare.cutoff_hz=4.8");
  CHECK_THAT(support::bytes_of(folder / "run/equation.txt"), !Catch::Contains("The band ends"));
  // Turned, the cube's part at 3.9 Hz looks like other products.
  CHECK(given.count("v^3") == 1);
  REQUIRE(given.count("x^2*v") == 1);
  const auto open = equation_of("");
  CHECK_THAT(support::bytes_of(folder / "run/equation.txt"), Catch::Contains("The band ends"));
  CHECK(open.count("v^3") == 0);
  if (open.count("x^2*v") == 1) CHECK(std::abs(open.at("x^2*v").first) < 0.5 * std::abs(given.at("x^2*v").first));
  REQUIRE(open.count("x^3") == 1);
  const auto [mean, std] = open.at("x^3");
  CHECK(mean == Approx(-30.0).margin(3.0 * std));
}

TEST_CASE("the same digits in other units give the same equation, scaled", "[apps][run_command][units]") {
  const Scratch folder;
  // A decay of 36 periods (0.8 % damping), printed to four decimals.
  std::string digits;
  for (int i = 0; i < 3000; ++i) {
    const double t = 0.005 * i, w = 15.0;
    digits += fmt::format("{:.3f},{:.4f}\n", t, 20.0 * std::exp(-0.008 * w * t) * std::cos(w * t));
  }
  const auto found = [&](const std::string& clock, const std::string& length) {
    const std::string name = clock + "_" + length;
    (void)folder.file(name + ".csv", "time_" + clock + ",displacement_" + length + "\n" + digits);
    const auto ended = support::run(folder, "$ARDENT -q run " + name + ".csv --force -o " + name);
    CAPTURE(name, ended.err);
    REQUIRE(ended.code == 0);
    json range = json::parse(support::bytes_of(folder / (name + "/equation.json")))["ranges"][0];
    const json rows = json::parse(support::bytes_of(folder / (name + "/metrics.json")))["ranges"][0];
    range["rows"] = {rows.at("num_train"), rows.at("num_test")};
    return range;
  };
  const json known = found("s", "m");
  const auto& terms = known["methods"][0]["terms"];
  REQUIRE(terms.size() == 2);
  for (const auto& [clock, in_s] : {std::pair{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}})
    for (const char* length : {"m", "mm"}) {
      const json other = found(clock, length);
      CAPTURE(clock, length);
      CHECK(other["verdict"] == known["verdict"]);
      CHECK(other["rows"] == known["rows"]);
      for (std::size_t m = 0; m < known["methods"].size(); ++m) {
        const json &ours = known["methods"][m]["terms"], &theirs = other["methods"][m]["terms"];
        REQUIRE(theirs.size() == ours.size());
        for (std::size_t i = 0; i < ours.size(); ++i) {
          REQUIRE(theirs[i]["name"] == ours[i]["name"]);
          // a of x: per squared second, of v: per second. Sums are rounded otherwise in other units: a deviation of a
          // fit that digits alone disturb is known to five of them.
          const double scale = ours[i]["name"] == "x" ? in_s * in_s : in_s;
          CHECK(scale * theirs[i]["mean"].get<double>() == Approx(ours[i]["mean"].get<double>()).epsilon(1e-6));
          CHECK(scale * theirs[i]["std"].get<double>() == Approx(ours[i]["std"].get<double>()).epsilon(1e-4));
        }
      }
    }
}

TEST_CASE("a table's columns in other units give the same terms, scaled", "[apps][run_command][units]") {
  const Scratch folder;
  const auto found = [&](double unit) {  // of x; a and v stay as they are
    std::string csv = "a,x,v\n";
    for (int i = 0; i < 400; ++i) {
      const double x = std::cos(0.37 * i), v = std::sin(0.53 * i);
      csv += fmt::format("{:.12g},{:.12g},{:.12g}\n", -3.0 * x - 0.2 * v + 0.01 * std::cos(1.7 * i * i), x / unit, v);
    }
    const std::string name = fmt::format("table_{:g}.csv", unit);
    (void)folder.file(name, csv);
    const auto ended = support::run(folder, "$ARDENT -q fit " + name + " --target a --terms x,v,x^2 --json");
    CAPTURE(ended.err);
    REQUIRE(ended.code == 0);
    return json::parse(ended.out)["ranges"][0];
  };
  const json in_m = found(1.0), in_mm = found(1e-3);
  REQUIRE(in_m["methods"].size() == in_mm["methods"].size());
  for (std::size_t m = 0; m < in_m["methods"].size(); ++m) {
    const json &ours = in_m["methods"][m]["terms"], &theirs = in_mm["methods"][m]["terms"];
    REQUIRE(ours.size() == theirs.size());
    for (std::size_t i = 0; i < ours.size(); ++i) {
      REQUIRE(ours[i]["name"] == theirs[i]["name"]);
      const double scale = ours[i]["name"] == "x" ? 1e3 : 1.0;
      for (const char* key : {"mean", "std"})  // twelve digits were printed
        CHECK(scale * theirs[i][key].get<double>() == Approx(ours[i][key].get<double>()).epsilon(1e-6));
    }
  }
}
