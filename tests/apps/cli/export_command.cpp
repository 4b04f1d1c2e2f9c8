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

void check_unit(const Scratch& folder, std::size_t num_terms) {
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
         "./importer opened/binaries/linux64/equation.so '" + guid + "' " + std::to_string(num_terms) +
             " unit/free_run.csv",
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
  const std::size_t num_terms = exported.at("parameters").size();
  CHECK(exported.at("covariance").size() == num_terms);
  for (const json& parameter : exported.at("parameters")) {
    bool found = false;
    for (const json& range : equation.at("ranges"))
      for (const json& method : range.at("methods"))
        for (const json& term : method.at("terms"))
          found = found || (range.at("name") == exported.at("range") && method.at("method") == exported.at("method") &&
                            term.at("name") == parameter.at("term") && term.at("mean") == parameter.at("mean") &&
                            term.at("std") == parameter.at("std"));
    CAPTURE(parameter.dump());
    CHECK(found);
  }
  expect(folder, "$ARDENT export run --to latex -o latex", 0, {});
  CHECK(bytes_of(folder / "latex/equation.tex").find("\\begin{equation}") != std::string::npos);
  expect(folder, "$ARDENT export run --to modelica -o modelica", 0, {});
  CHECK(bytes_of(folder / "modelica/Equation.mo").find("end Equation;") != std::string::npos);
  check_unit(folder, num_terms);
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
