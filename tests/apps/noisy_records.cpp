// One noisy recording of one channel and a force, as a config-less run takes it.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "support/program.hpp"

using nlohmann::json;
using support::bytes_of;
using support::run;
using support::Scratch;

namespace test_noisy_records {

namespace {

/// The chosen columns of a table of a simulation.
std::string columns_of(const std::string& table, const std::vector<std::string>& names) {
  std::istringstream lines(table);
  std::string line, result;
  std::vector<std::size_t> columns;
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    if (columns.empty())
      for (const std::string& name : names)
        columns.push_back(static_cast<std::size_t>(std::find(cells.begin(), cells.end(), name) - cells.begin()));
    for (std::size_t i = 0; i < columns.size(); ++i) result += (i > 0 ? "," : "") + cells.at(columns[i]);
    result += '\n';
  }
  return result;
}

/// A run of these columns of 25 s of the paper's Duffing oscillator gives its four terms, each within four standard
/// deviations, which are small, and follows the rest of the record.
void check_duffing(const std::vector<std::string>& names, const std::string& noise, double known_to) {
  const Scratch folder;
  REQUIRE(run(folder, "$ARDENT -q sim duffing --seed 602 --noise " + noise + " -o duffing").code == 0);
  (void)folder.file("table.csv", columns_of(bytes_of(folder / "duffing/response.csv"), names));
  const auto ended = run(folder, "$ARDENT -q run table.csv -o out");
  CAPTURE(noise, ended.out, ended.err);
  REQUIRE(ended.code == 0);
  CHECK_THAT(ended.out, Catch::Contains("by the likelihood") && Catch::Contains("This equation describes the record"));
  // Of an acceleration alone it follows what was recorded, to its noise.
  const json metrics = json::parse(bytes_of(folder / "out/metrics.json"));
  for (const json& range : metrics.at("ranges"))
    if (const json& nmse = range.at("methods").at(0).at("nmse"); names[1] == "a" && nmse.contains("recorded_run")) {
      CHECK(nmse["recorded_run"]["channel"] == "a");
      CHECK(nmse["recorded_run"]["nmse"].get<double>() == Approx(std::pow(std::stod(noise), 2)).epsilon(0.3));
    }
  const json document = json::parse(bytes_of(folder / "out/equation.json"));
  std::map<std::string, double> truth{{"x", -25.0}, {"v", -1.0}, {"x^3", -2500.0}, {"f", 100.0}};
  for (const json& range : document.at("ranges")) {
    if (range.at("name") != document.at("chosen").at("range")) continue;
    const json& terms = range.at("methods").at(0).at("terms");
    CHECK(terms.size() == truth.size());
    for (const json& term : terms) {
      CAPTURE(term.dump());
      REQUIRE(truth.contains(term.at("name")));
      const double value = truth.at(term.at("name")), std = term.at("std");
      CHECK(std::abs(term.at("mean").get<double>() - value) < 4.0 * std);
      CHECK(std < known_to * std::abs(value));
    }
  }
}

}  // namespace

TEST_CASE("a noisy displacement alone gives the equation", "[apps][noisy_records]") {
  check_duffing({"t", "x", "f"}, "0.01", 0.01);
  check_duffing({"t", "x", "f"}, "0.05", 0.05);
  check_duffing({"t", "x", "f"}, "0.1", 0.1);
}

TEST_CASE("a noisy acceleration alone gives the equation", "[apps][noisy_records]") {
  check_duffing({"t", "a", "f"}, "0.05", 0.05);
  check_duffing({"t", "a", "f"}, "0.1", 0.1);
}

TEST_CASE("seven noisy displacements, each with noise of its own, give dry friction one equation",
          "[apps][noisy_records]") {
  const Scratch folder;
  std::string config;
  for (const std::string ratio : {"0.7", "0.8", "0.9", "1.0", "1.1", "1.2", "1.3"}) {
    REQUIRE(run(folder, "$ARDENT -q sim coulomb --noise 0.05 --seed 6" + ratio.substr(2) + ratio.substr(0, 1) +
                            " --set ratio=" + ratio + " -o at-" + ratio)
                .code == 0);
    (void)folder.file(ratio + ".csv",
                      columns_of(bytes_of(folder / ("at-" + ratio + "/response.csv")), {"t", "x", "f"}));
    config += "[[recording]]\nfile = \"" + ratio + ".csv\"\n";
  }
  (void)folder.file("seven.toml", config);
  const auto ended = run(folder, "$ARDENT -q run seven.toml -o out");
  CAPTURE(ended.out, ended.err);
  REQUIRE(ended.code == 0);
  const json document = json::parse(bytes_of(folder / "out/equation.json"));
  CHECK(document.at("chosen").at("range") == "all recordings");
  const std::map<std::string, double> truth{{"x", -1000.0}, {"v", -2.0}, {"sgn(v)", -1.0}, {"f", 100.0}};
  for (const json& range : document.at("ranges")) {
    if (range.at("name") != "all recordings") continue;
    const json& terms = range.at("methods").at(0).at("terms");
    CHECK(terms.size() == truth.size());
    for (const json& term : terms) {
      CAPTURE(term.dump());
      REQUIRE(truth.contains(term.at("name")));
      CHECK(std::abs(term.at("mean").get<double>() - truth.at(term.at("name"))) < 4.0 * term.at("std").get<double>());
    }
  }
}

}  // namespace test_noisy_records
