// An exported equation, run by the tools it was written for, moves as the run's own.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "support/program.hpp"

namespace fs = std::filesystem;
using nlohmann::json;
using support::bytes_of;
using support::expect;
using support::Scratch;

namespace test_export_command {

namespace {

constexpr const char* python =
    "for p in python3 /usr/bin/python3; do $p -c 'import scipy' 2>/dev/null && exec $p python/equation.py; done; exit "
    "77";

/// x exported in this language is that of the run's equation to 1e-8; a tool that is not installed is told.
void check_by(const Scratch& folder, const std::string& language, const std::string& command) {
  expect(folder, "$ARDENT export run --to " + language + " -o " + language, 0, {});
  const support::Ended ended = support::run(folder, command);
  CAPTURE(language, ended.out, ended.err);
  if (ended.code == 77 || ended.code == 127)
    WARN("skipped: nothing that runs " << language);
  else
    CHECK(ended.code == 0);
}

/// What stands between two texts, where `begin` first is.
std::string between(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t at = text.find(begin) + begin.size();
  return text.substr(at, text.find(end, at) - at);
}

void check_unit(const Scratch& folder, const json& exported) {
  expect(folder, "$ARDENT export run --to fmu -o unit", 0, {});
  const std::string description = bytes_of(folder / "unit/modelDescription.xml"),
                    guid = between(description, "guid=\"", "\"");
  CHECK(description.find("modelIdentifier=\"equation\"") != std::string::npos);
  expect(folder,
         "python3 -c \"import zipfile, xml.dom.minidom; z = zipfile.ZipFile('unit/equation.fmu'); assert "
         "z.testzip() is None; z.extractall('opened'); xml.dom.minidom.parse('opened/modelDescription.xml')\"",
         0, {});
  expect(folder, "cc -Wall -Wextra -Werror -O1 -o importer '" ARDENT_SOURCES "/tests/apps/cli/importer.c' -ldl -lm", 0,
         {});
  expect(folder,
         "./importer opened/binaries/linux64/equation.so '" + guid + "' " +
             std::to_string(exported.at("parameters").size()) + " " + std::to_string(exported.at("states").size()) +
             " " + std::to_string(exported.at("states").size() < 4 ? 1 : 2) + " unit/free_run.csv",
         0, {});
}

void check_exports(const Scratch& folder) {
  const json equation = json::parse(bytes_of(folder / "run/equation.json"));
  check_by(folder, "c", "cc -Wall -Wextra -Werror -O2 -DEQUATION_MAIN c/equation.c -o from-c -lm && cd c && ../from-c");
  check_by(folder, "python", python);
  check_by(folder, "matlab",
           "which octave >/dev/null || exit 77; cd matlab && octave --no-gui --quiet --eval equation");
  expect(folder, "$ARDENT export run --to json -o json", 0, {});
  const json exported = json::parse(bytes_of(folder / "json/equation.json"));
  CHECK(exported.at("covariance").size() == exported.at("parameters").size());
  // What the run has: terms of a range and method, or of bodies and an inner state.
  std::vector<json> own;
  for (const json& range : equation.at("ranges"))
    for (const json& method : range.at("methods"))
      if (range.at("name") == exported.at("range") && method.at("method") == exported.at("method"))
        own.push_back(method);
  if (equation.contains("bodies")) own.assign(equation["bodies"].begin(), equation["bodies"].end());
  if (equation.contains("inner")) own.push_back(equation["inner"]);
  for (const json& parameter : exported.at("parameters")) {
    bool found = false;
    for (const json& one : own)
      for (const json& term : one.at("terms"))
        found = found || (term.at("name") == parameter.at("term") && term.at("mean") == parameter.at("mean") &&
                          term.at("std") == parameter.at("std") &&
                          parameter.value("target", one.value("target", "")) == one.value("target", ""));
    CAPTURE(parameter.dump());
    CHECK(found);
  }
  expect(folder, "$ARDENT export run --to latex -o latex", 0, {});
  CHECK(bytes_of(folder / "latex/equation.tex").find("\\begin{equation}") != std::string::npos);
  expect(folder, "$ARDENT export run --to modelica -o modelica", 0, {});
  CHECK(bytes_of(folder / "modelica/Equation.mo").find("end Equation;") != std::string::npos);
  check_unit(folder, exported);
}

/// What the run's own free run has for a displacement, from predictions.csv, against what is exported: between samples
/// the two take the inputs a little differently, by 3e-4 of the motion where a force yields, and the run's steps are
/// longer.
void check_free_run(const Scratch& folder, std::size_t num_inputs, std::size_t num_bodies) {
  expect(
      folder,
      "python3 -c \"\nown = [l.split(',') for l in open('run/predictions.csv')][1:]\nexported = [l.split(',') for l in "
      "open('c/free_run.csv')][1::8]\nassert len(own) == len(exported)\nfor body in range(" +
          std::to_string(num_bodies) + "):\n    x = [float(l[2 + 2 * body]) for l in own]\n    y = [float(l[1 + " +
          std::to_string(num_inputs) +
          " + body]) for l in exported]\n    apart = max(abs(a - b) for a, b in zip(x, y)) / max(map(abs, x))\n"
          "    assert apart < 1e-3, apart\n\"",
      0, {});
}

}  // namespace

TEST_CASE("an exported equation moves as the run's, in each language", "[apps][export]") {
  const Scratch folder;
  expect(folder, "$ARDENT -q sim duffing --noise 0.01 --seed 7 -o sim && $ARDENT -q run sim/response.csv -o run", 0,
         {});
  check_exports(folder);
}

TEST_CASE("so does one with dry friction", "[apps][export]") {
  const Scratch folder;
  expect(folder, "$ARDENT -q sim coulomb --noise 0.001 --seed 7 -o sim && $ARDENT -q run sim/response.csv -o run", 0,
         {});
  REQUIRE(bytes_of(folder / "run/equation.txt").find("sgn(v)") != std::string::npos);
  check_exports(folder);
}

TEST_CASE("so do those of two bodies", "[apps][export][bodies]") {
  const Scratch folder;
  SECTION("a force on the first") {
    expect(folder,
           "$ARDENT -q sim chain --noise 0.01 --seed 7 --duration 30 -o sim && $ARDENT -q run sim/response.csv -o run",
           0, {});
    check_exports(folder);
    check_free_run(folder, 1, 2);
  }
  SECTION("dry friction between both and against the ground") {
    expect(folder,
           "$ARDENT -q sim chain --set friction=0.4 --noise 0.001 --seed 7 --duration 20 -o sim && $ARDENT -q "
           "run sim/response.csv -o run",
           0, {});
    const std::string equations = bytes_of(folder / "run/equation.txt");
    REQUIRE(equations.find("sgn(v1)") != std::string::npos);
    REQUIRE(equations.find("sgn(v2") != std::string::npos);
    check_exports(folder);
  }
  SECTION("a base that moves, against which friction acts") {
    expect(folder,
           "$ARDENT -q sim chain --set base=1 --set friction=0.3 --set rms=0.05 --noise 0.001 --seed 7 --duration 20 "
           "-o sim && "
           "$ARDENT -q run sim/response.csv -o run",
           0, {});
    REQUIRE(bytes_of(folder / "run/equation.txt").find("sgn(v1") != std::string::npos);
    check_exports(folder);
  }
}

TEST_CASE("so do those of one body with an inner state", "[apps][export][bodies][memory]") {
  const Scratch folder;
  SECTION("a hysteretic force") {
    expect(folder,
           "$ARDENT -q sim chain -o drive --set from_hz=0.3 --set to_hz=2 --set rms=40 --seed 7 && $ARDENT -q sim "
           "bouc-wen --set a=0.2 --drive drive/response.csv -o sim --noise 0.01 && cut -d, -f1,2,7 sim/response.csv > "
           "own.csv && $ARDENT -q run own.csv -o run --set library.inner=hysteresis",
           0, {});
  }
  SECTION("a lag") {
    expect(folder,
           "$ARDENT -q sim chain -o drive --set from_hz=0.3 --set to_hz=2 --set rms=5 --seed 9 && $ARDENT -q sim "
           "duffing --drive drive/response.csv --lag 0.1 --noise 0.01 -o sim && cut -d, -f1,2,5 sim/response.csv > "
           "own.csv && $ARDENT -q run own.csv -o run --set library.inner=lag",
           0, {});
  }
  REQUIRE(json::parse(bytes_of(folder / "run/equation.json")).at("inner").at("kept") == true);
  check_exports(folder);
  check_free_run(folder, 1, 1);
  expect(folder, "$ARDENT export run --to c --range all -o no", 2, {"--range", "one body"});
}

TEST_CASE("an export says what it cannot", "[apps][export]") {
  const Scratch folder;
  expect(folder, "$ARDENT -q sim duffing --duration 10 -o sim && $ARDENT -q run sim/response.csv -o run", 0, {});
  expect(folder, "$ARDENT export nothing --to c", 3, {"nothing"});
  expect(folder, "$ARDENT export run --to cobol", 2, {"cobol", "python"});
  expect(folder, "$ARDENT export run --to c -o out && $ARDENT export run --to c -o out", 5, {"--force"});
  expect(folder, "$ARDENT export run --to c -o out --force", 0, {});
  (void)folder.file("mine", "my own");
  expect(folder, "$ARDENT export run --to c -o mine --force", 5, {"mine"});
  CHECK(bytes_of(folder / "mine") == "my own");
  expect(folder, "PATH=/nowhere $ARDENT export run --to fmu -o unit", 5, {"[export.compiler]", "--to c"});
  CHECK_FALSE(fs::exists(folder / "unit"));
  expect(folder, "$ARDENT -q run sim/response.csv -o bare --no-rows && $ARDENT export bare --to c -o of-bare", 0,
         {"[export.no_free_run]"});
}

}  // namespace test_export_command
