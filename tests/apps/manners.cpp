// What a person is told who made a mistake, or several: each names what was found, what is wanted and what to type.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "apps/config/config.hpp"
#include "apps/output/factors_file.hpp"
#include "apps/output/finished_run.hpp"
#include "apps/output/manifest.hpp"
#include "apps/process/sha256.hpp"
#include "support/program.hpp"

namespace test_manners {

using nlohmann::json;
using support::bytes_of;
using support::expect;
using support::Scratch;
namespace fs = std::filesystem;

namespace {

/// A forced oscillation for ten seconds at 100 Hz, in mm and N.
void record(const Scratch& folder, const std::string& name, double frequency = 7.0) {
  std::string text = "time_s,x_mm,force_N\n";
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.01 * i;
    const double x = 10.0 * std::sin(frequency * t) + 4.0 * std::sin(4.3 * t + 1.0);
    text += std::to_string(t) + "," + std::to_string(x) + "," + std::to_string(std::sin(frequency * t + 0.2)) + "\n";
  }
  (void)folder.file(name, text);
}

struct Case {
  std::string what, text;
  std::vector<std::string> pieces;
};

}  // namespace

TEST_CASE("all that is wrong with terms and conditions is said at once, with what is wrong with the recording",
          "[apps][manners]") {
  const Scratch folder;
  record(folder, "drive.csv");
  const std::string head = "schema = 1\n[[recording]]\nfile = \"drive.csv\"\n";
  (void)folder.file("syntax.toml", head + "[library]\nterms = [\"x^^2\", \"abs(x\"]\n[[range]]\nwhere = \"v >\"\n");
  const json syntax = json::parse(expect(folder, "$ARDENT check syntax.toml --json", 2, {}).out)["error"];
  CHECK_THAT(syntax["message"].get<std::string>(), Catch::Contains("syntax.toml:5") && Catch::Contains("'x^^2'"));
  REQUIRE(syntax["further"].size() == 2);
  CHECK_THAT(syntax["further"][0]["message"].get<std::string>(), Catch::Contains("'abs(x'"));
  CHECK_THAT(syntax["further"][1]["message"].get<std::string>(), Catch::Contains("syntax.toml:6: where"));

  (void)folder.file("names.toml", head +
                                      "[library]\nterms = [\"foo(x)\", \"q*x\"]\n[fit]\ntarget = \"aa\"\n"
                                      "[[range]]\nwhere = \"w > 1\"\n");
  const json names = json::parse(expect(folder, "$ARDENT run names.toml -o o --json", 2, {}).out)["error"];
  CHECK(names["further"].size() == 3);
  CHECK_FALSE(fs::exists(folder / "o"));

  (void)folder.file("drive.csv.toml",
                    "[[channel]]\nname = \"d\"\ncolumn = \"x_mm\"\nrole = \"y1\"\nunit = \"mN\"\n"
                    "delay = \"3 N\"\n[[channel]]\nname = \"f\"\ncolumn = \"force_N\"\nrole = \"q\"\n");
  const auto both = expect(folder, "$ARDENT check syntax.toml", 2,
                           {"x^^2", "drive.csv.toml:4: [[channel]] 1: role", "drive.csv.toml:6: [[channel]] 1: delay",
                            "drive.csv.toml:10: [[channel]] 2: role"});
  CHECK(std::count(both.err.begin(), both.err.end(), '\n') == 6);
}

TEST_CASE("a unit of another dimension than the role or the column is refused with the line and what fits",
          "[apps][manners]") {
  const Scratch folder;
  record(folder, "drive.csv");
  for (const Case& one :
       {Case{"a force as displacement",
             "role = \"x\"\nunit = \"N\"\n",
             {"drive.csv.toml:4: [[channel]] 1: role", "x is measured in m", "unit is N", "fits role f, z or other"}},
        Case{"an acceleration as displacement",
             "role = \"y\"\nunit = \"g\"\n",
             {"drive.csv.toml:4", "m/s^2, which fits role ddr, ddy or a"}},
        Case{"a column in mm as a pressure",
             "role = \"f\"\nunit = \"bar\"\n",
             {"drive.csv.toml:1", "unit = \"bar\"", "column 'x_mm' is in mm", "full_scale = \"1 bar\""}},
        Case{
            "a column in mm as an acceleration",
            "role = \"ddr\"\n",
            {"drive.csv.toml:1", "channel 'd' is in m, which fits role r, y or x", "role ddr is measured in m/s^2"}}}) {
    CAPTURE(one.what);
    (void)folder.file("drive.csv.toml", "[[channel]]\nname = \"d\"\ncolumn = \"x_mm\"\n" + one.text);
    expect(folder, "$ARDENT check drive.csv", 2, one.pieces);
  }
  // The same dimension is a correction, and a raw displacement in V a matter of taste.
  for (const char* text : {"column = \"x_mm\"\nrole = \"x\"\nunit = \"cm\"\n", "column = \"x_mm\"\nrole = \"f\"\n"}) {
    (void)folder.file("drive.csv.toml", std::string("[[channel]]\nname = \"d\"\n") + text);
    expect(folder, "$ARDENT info drive.csv", 0, {"channel"});
  }
}

TEST_CASE("keys of [segment] that are gone name what is in their place", "[apps][manners]") {
  const Scratch folder;
  record(folder, "drive.csv");
  for (const Case& one :
       {Case{"high",
             "high_enter_m = 0.01",
             {"old.toml:4: segment.high_enter_m: is no key any more", "high_amplitude_m"}},
        Case{"low", "high_leave_m = 0.01", {"segment.high_leave_m", "high_amplitude_m"}},
        Case{"window", "envelope_window_s = 2", {"segment.envelope_window_s", "remove the line"}},
        Case{"stop", "stick_duration_s = 0.5", {"segment.stick_duration_s", "follows from the record"}},
        Case{"halt", "stick_halt_s = 0.5", {"segment.stick_halt_s", "remove the line"}}}) {
    CAPTURE(one.what);
    (void)folder.file("old.toml", "[[recording]]\nfile = \"drive.csv\"\n[segment]\n" + one.text + "\n");
    const auto ended = expect(folder, "$ARDENT check old.toml", 2, one.pieces);
    CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
    CHECK_THAT(ended.err, Catch::Contains("[config.former_key]"));
  }
  CHECK_THAT(expect(folder, "$ARDENT help config", 0, {}).out, !Catch::Contains("high_enter_m"));
}

TEST_CASE("a draft states nothing that was assumed", "[apps][manners]") {
  const Scratch folder;
  std::string text = "t,x,force_N\n";
  for (int i = 0; i < 100; ++i) text += std::to_string(0.5 * i) + "," + std::to_string(i % 7) + ",1\n";
  (void)folder.file("a.csv", text);
  expect(folder, "$ARDENT init a.csv", 0, {});
  const std::string draft = bytes_of(folder / "a.csv.toml");
  CHECK_THAT(draft, !Catch::Contains("\nrate = ") && Catch::Contains("\n# rate = 2  # Hz, if column 1 is time in s"));
  CHECK_THAT(draft, !Catch::Contains("\nunit = \"m\"") && Catch::Contains("\n# unit = \"m\"  # if so"));
  CHECK_THAT(draft, Catch::Contains("\nunit = \"N\""));
  expect(folder, "$ARDENT info a.csv", 0, {"rate       2 Hz"});
}

TEST_CASE("a study skips a value that does not go with the recording and says why", "[apps][manners]") {
  const Scratch folder;
  record(folder, "drive.csv");
  const std::string study = "$ARDENT -q study drive.csv --set 'fit.methods=[\"fast_rvm\"]' -o o --force --json --over ";
  const json cells = json::parse(expect(folder, study + "cutoff_hz=10,80", 0, {}).out)["cells"];
  bool is_skipped = false;
  for (const json& cell : cells)
    if (cell.contains("reason")) {
      is_skipped = true;
      CHECK_THAT(cell["reason"].get<std::string>(), Catch::StartsWith("skipped: ") && Catch::Contains("got 80"));
    }
  CHECK(is_skipped);
  expect(folder, study + "order=1,-2", 0, {"skipped: library.order: got -2"});
  expect(folder, study + "order=1,two", 2, {"[config.type]", "two"});
  for (const char* none : {"cutoff_hz=80,90 --grid", "cutoff_hz=80"}) expect(folder, study + none, 2, {"got 80"});
}

TEST_CASE("what is left out is said whether regimes are looked for or not", "[apps][manners]") {
  const Scratch folder;
  record(folder, "drive.csv");
  for (const char* find : {"true", "false"})
    expect(folder, std::string("$ARDENT check drive.csv --set segment.find=") + find, 0,
           {"regime.left_out", "ends of the record"});
}

TEST_CASE("a recording that was fitted is known by its bytes, not by its name", "[apps][manners]") {
  const Scratch folder;
  record(folder, "drive.csv");
  fs::create_directory(folder / "elsewhere");
  record(folder, "elsewhere/drive.csv", 6.0);
  fs::copy(folder / "drive.csv", folder / "copy.csv");
  expect(folder, "$ARDENT -q run drive.csv -o run --set 'fit.methods=[\"ols\"]' --set library.order=1", 0, {});
  CHECK_THAT(expect(folder, "$ARDENT merge run run", 3, {"[factors.twice]", "the same recording"}).err,
             !Catch::Contains("factors.differ"));
  const apps::Config config = apps::read_config(folder / "run/config.toml");
  const apps::Manifest run = *apps::read_manifest(folder / "run");
  const auto name_of = [&](const char* file) {
    return apps::fitted_name(run, config, apps::sha256_file(folder / file));
  };
  CHECK(name_of("drive.csv") == "drive.csv");
  CHECK(name_of("copy.csv") == "drive.csv");
  CHECK(name_of("elsewhere/drive.csv").empty());
  apps::Manifest nameless = run;  // as programs wrote it that knew recordings by their paths
  for (apps::ManifestFile& input : nameless.inputs) input.recording.clear();
  CHECK(apps::fitted_name(nameless, config, apps::sha256_file(folder / "copy.csv")) == "drive.csv");
  CHECK(apps::fitted_name(nameless, config, apps::sha256_file(folder / "elsewhere/drive.csv")).empty());
}

TEST_CASE("records of one name from different runs are told apart by their runs", "[apps][manners]") {
  const auto records = [](const std::vector<std::string>& names) {
    std::vector<ident::RecordFactors> list;
    for (const std::string& name : names) list.push_back({.record = name});
    return list;
  };
  const auto all = apps::name_apart({records({"drive.csv", "drive.csv"}), records({"drive.csv", "other.csv"})},
                                    {"mon/run", "tue/run"});
  REQUIRE(all.size() == 4);
  CHECK(all[0].record == "mon/run: drive.csv");
  CHECK(all[1].record == "mon/run: drive.csv");  // two ranges of one
  CHECK(all[2].record == "tue/run: drive.csv");
  CHECK(all[3].record == "other.csv");
}

TEST_CASE("a channel that begins late is used from where it begins", "[apps][manners]") {
  const Scratch folder;
  record(folder, "drive.csv");
  expect(
      folder,
      "awk -F, 'NR>1 && NR<302 {print $1 \",NaN,\" $3; next} {print}' drive.csv > late.csv && $ARDENT check late.csv",
      0, {"x: no values before 3 s, which is marked bad", "no values in x"});
  expect(folder,
         "awk -F, 'NR>1 {print $1 \",NaN,\" $3; next} {print}' drive.csv > never.csv && $ARDENT check never.csv", 3,
         {"[motion.none]", "found force", "'x_mm' (no values)"});
}

TEST_CASE("an equation of a handful of rows is said to be one", "[apps][manners]") {
  const Scratch folder;
  record(folder, "drive.csv");
  expect(folder,
         "head -121 drive.csv > short.csv && $ARDENT -q run short.csv -o run --set prepare.cutoff_hz=30 && "
         "head -c 100000 run/equation.txt",
         0, {"rows were fitted, with"});
  CHECK_THAT(bytes_of(folder / "run/report.html"), Catch::Contains("check it on another recording"));
  CHECK_THAT(
      expect(folder, "$ARDENT -q run drive.csv -o long --set prepare.cutoff_hz=20 && cat long/equation.txt", 0, {}).out,
      !Catch::Contains("rows were fitted, with"));
}

namespace {

/// Two recordings of one name, forces of 6 and 7, and a config of both.
void make_days(const Scratch& folder) {
  for (const char* day : {"mon", "tue"}) {
    fs::create_directory(folder / day);
    record(folder, std::string(day) + "/drive.csv", *day == 'm' ? 7.0 : 6.0);
  }
  (void)folder.file("both.toml",
                    "[[recording]]\nfile = \"mon/drive.csv\"\n[[recording]]\nfile = \"tue/drive.csv\"\n"
                    "[library]\norder = 1\n[fit]\nmethods = [\"ols\"]\n");
}

std::vector<std::string> recordings_in(const json& segments) {
  std::set<std::string> names;
  for (const json& interval : segments) names.insert(interval["recording"].get<std::string>());
  return {names.begin(), names.end()};
}

}  // namespace

TEST_CASE("two recordings of one name in a run are told apart by their folders", "[apps][manners][names]") {
  const Scratch folder;
  make_days(folder);
  expect(folder, "$ARDENT run both.toml -o run", 0, {"mon/drive.csv: ", "tue/drive.csv: "});
  std::vector<std::string> ranges;
  const json equation = json::parse(bytes_of(folder / "run/equation.json"));
  for (const json& range : equation["ranges"]) ranges.push_back(range["name"]);
  CHECK(ranges == std::vector<std::string>{"mon/drive", "tue/drive", "all recordings"});
  const json segments = json::parse(bytes_of(folder / "run/segments.json"));
  CHECK(recordings_in(segments) == std::vector<std::string>{"mon/drive.csv", "tue/drive.csv"});
  expect(folder, "$ARDENT -q run both.toml -o again --set segment.file=run/segments.json", 0, {});
  CHECK(bytes_of(folder / "again/metrics.json") == bytes_of(folder / "run/metrics.json"));
}

TEST_CASE("names do not depend on where a command is typed or how a path is written", "[apps][manners][names]") {
  const Scratch folder;
  make_days(folder);
  const std::string absolute = fs::canonical(folder / "tue").string();
  (void)folder.file("mon/both.toml",
                    "[[recording]]\nfile = \"drive.csv\"\n[[recording]]\nfile = \"../tue/drive.csv\"\n"
                    "[library]\norder = 1\n[fit]\nmethods = [\"ols\"]\n");
  (void)folder.file("absolute.toml", "[[recording]]\nfile = \"mon/../mon/drive.csv\"\n[[recording]]\nfile = \"" +
                                         absolute + "/drive.csv\"\n[library]\norder = 1\n[fit]\nmethods = [\"ols\"]\n");
  expect(folder, "$ARDENT -q run both.toml -o run", 0, {});
  expect(folder, "cd mon && $ARDENT -q run both.toml -o ../second", 0, {});
  expect(folder, "cd tue && $ARDENT -q run ../absolute.toml -o ../third", 0, {});
  for (const char* run : {"second", "third"}) {
    CAPTURE(run);
    for (const char* file : {"metrics.json", "equation.json", "segments.json", "quality.json"})
      CHECK(bytes_of(folder / run / file) == bytes_of(folder / "run" / file));
    // Segments of one run handed to another, from a third folder.
    expect(folder,
           std::string("cd mon && $ARDENT -q run both.toml -o again --force --set segment.file=../") + run +
               "/segments.json",
           0, {});
  }
  expect(folder, "cd tue && $ARDENT run ../second --json", 0, {"\"same\": true"});
  const auto predicted = [&](const std::string& command) {
    expect(folder, command + " -o " + (folder / "predicted").string() + " --force", 0, {});
    return json::parse(bytes_of(folder / "predicted/predict.json"));
  };
  const json whole = predicted("$ARDENT -q predict run tue/drive.csv");
  CHECK(whole["recording"] == "tue/drive.csv");
  CHECK(predicted("cd tue && $ARDENT -q predict ../second drive.csv") == whole);
  CHECK(predicted("cd mon && $ARDENT -q predict ../third " + absolute + "/drive.csv") == whole);
}

TEST_CASE("a run folder keeps the names of its recordings, whatever becomes of their folders",
          "[apps][manners][names]") {
  const Scratch folder;
  fs::create_directory(folder / "site");
  fs::create_directory(folder / "site/sub");
  record(folder, "site/drive.csv");
  record(folder, "site/sub/drive.csv", 6.0);
  (void)folder.file("site/both.toml",
                    "[[recording]]\nfile = \"drive.csv\"\n[[recording]]\nfile = \"sub/drive.csv\"\n"
                    "[library]\norder = 1\n[fit]\nmethods = [\"ols\"]\n");
  expect(folder, "cd site && $ARDENT -q run both.toml -o run && cd .. && mv site moved && $ARDENT run moved/run", 0,
         {"results"});
  const apps::Manifest run = *apps::read_manifest(folder / "moved/run");
  const apps::Config config = apps::read_config(folder / "moved/run/config.toml");
  CHECK(apps::fitted_name(run, config, apps::sha256_file(folder / "moved/drive.csv")) == "site/drive.csv");
  expect(folder, "$ARDENT predict moved/run moved/drive.csv", 0, {"site/drive.csv: error"});
}

TEST_CASE("a range is about the recording that outputs call so, however short where that is clear",
          "[apps][manners][names]") {
  const Scratch folder;
  make_days(folder);
  fs::copy(folder / "tue/drive.csv", folder / "tue/other.csv");
  const std::string head =
      "[[recording]]\nfile = \"mon/drive.csv\"\n[[recording]]\nfile = \"tue/drive.csv\"\n"
      "[[recording]]\nfile = \"tue/other.csv\"\n[[range]]\nrecording = ";
  for (const auto& [name, number] : {std::pair{"mon/drive.csv", 1}, std::pair{"tue/drive.csv", 2},
                                     std::pair{"tue/drive", 2}, std::pair{"other.csv", 3}, std::pair{"other", 3}}) {
    CAPTURE(name);
    const auto file = folder.file("c.toml", head + "\"" + name + "\"\n");
    CHECK(apps::read_config(file).ranges.front().recording == number);
  }
  (void)folder.file("c.toml", head + "\"drive.csv\"\n");
  expect(folder, "$ARDENT run c.toml -o run", 2,
         {"several recordings are called 'drive.csv', want one of mon/drive.csv, tue/drive.csv, other.csv"});
  (void)folder.file("c.toml", head + "\"wed/drive.csv\"\n");
  expect(folder, "$ARDENT run c.toml -o run", 2, {"no recording 'wed/drive.csv', want one of mon/drive.csv"});
}

}  // namespace test_manners
