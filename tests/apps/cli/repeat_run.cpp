#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "support/program.hpp"

namespace fs = std::filesystem;
using nlohmann::json;
using support::expect;
using support::Scratch;

namespace {

void make_run(const Scratch& folder) {
  REQUIRE(support::run(folder, "$ARDENT sim duffing --duration 10 --noise 0.01 -o d").code == 0);
  (void)folder.file("c.toml",
                    "[[recording]]\nfile = \"d/response.csv\"\n[library]\norder = 3\n[[range]]\nname = \"all\"\n");
  REQUIRE(support::run(folder, "$ARDENT run c.toml -o r").code == 0);
}

}  // namespace

TEST_CASE("a run repeats bit for bit from its folder, and the temporary one goes", "[apps][repeat]") {
  const Scratch folder;
  make_run(folder);
  fs::create_directory(folder / "tmp");
  const auto again = expect(folder, "TMPDIR=$PWD/tmp $ARDENT run r --json", 0, {});
  CHECK(fs::is_empty(folder / "tmp"));
  const json document = json::parse(again.out);
  CHECK(document["same"] == true);
  CHECK(document["program"]["same"] == true);
  CHECK(document["results"].size() >= 9);
  for (const json& file : document["results"]) CHECK(file["path"] != "log.txt");
  // Kept elsewhere it is a run like any other, and its own repeat is the same, too.
  expect(folder, "mkdir deep && $ARDENT run r -o deep/again && $ARDENT run deep/again", 0,
         {"the repeat is in deep/again"});
  CHECK(support::bytes_of(folder / "r/metrics.json") == support::bytes_of(folder / "deep/again/metrics.json"));
}

TEST_CASE("a repeat says which input, which result and which program is another", "[apps][repeat]") {
  const Scratch folder;
  make_run(folder);
  expect(folder, "echo '# note' >> c.toml; $ARDENT run r", 0, {"c.toml: differs; not read again"});
  expect(folder, "sed -i 's/\"version\": \"/&9./' r/manifest.json; $ARDENT run r", 0,
         {"program  differs", "then ardent 9."});
  // The manifest says otherwise than the numbers: what a changed program would do.
  json manifest = json::parse(support::bytes_of(folder / "r/manifest.json"));
  for (json& output : manifest["outputs"])
    if (output["path"] == "metrics.json") output["sha256"] = std::string(64, '0');
  (void)folder.file("r/manifest.json", manifest.dump());
  expect(folder, "$ARDENT run r", 4, {"metrics.json: differs", "error [repeat.results]"});
  expect(folder, "echo 'title = \"new\"' > d/response.csv.toml; $ARDENT run r", 3,
         {"d/response.csv.toml: is new", "1 of 3 files the same", "error [repeat.inputs]"});
  fs::remove(folder / "d/response.csv.toml");
  expect(folder, "sed -i '$ s/.$/1/' d/response.csv; $ARDENT run r", 3,
         {"response.csv: differs", "error [repeat.inputs]"});
  expect(folder, "rm d/response.csv; $ARDENT run r", 3, {"d/response.csv"});
}

TEST_CASE("only a run as it is can be repeated", "[apps][repeat]") {
  const Scratch folder;
  make_run(folder);
  expect(folder, "$ARDENT run d", 2, {"[run.repeat] d: was written by ardent sim", "ardent sim duffing"});
  expect(folder, "$ARDENT run r --set fit.tau=3", 2, {"[run.repeat]", "r/config.toml"});
  expect(folder, "mkdir plain; $ARDENT run plain", 3, {"plain: is a directory"});
}

TEST_CASE("a verdict can be required", "[apps][repeat]") {
  const Scratch folder;
  REQUIRE(support::run(folder, "$ARDENT sim duffing --duration 20 -o d").code == 0);
  const std::string run = "$ARDENT run d/response.csv --set 'fit.methods=[\"fast_rvm\"]' ";
  expect(folder, run + "-o good --require describes", 0, {});
  expect(folder, run + "-o poor --set library.order=1 --set library.terms=[] --require describes", 4,
         {"error [verdict.required] range 'all': the verdict is does_not"});
  CHECK(fs::exists(folder / "poor/manifest.json"));
  expect(folder, run + "-o odd --require perfect", 2, {"--require", "describes"});
}

TEST_CASE("one sidecar serves many recordings", "[apps][repeat]") {
  const Scratch folder;
  REQUIRE(support::run(folder, "$ARDENT sim duffing --duration 10 -o d").code == 0);
  (void)folder.file("rig.toml",
                    "[[channel]]\nname = \"x\"\nrole = \"x\"\nunit = \"mm\"\n[[channel]]\nname = \"a\"\nrole "
                    "= \"a\"\nunit = \"mm/s^2\"\n");
  for (const char* name : {"mon", "tue"}) {
    const std::string csv = std::string(name) + ".csv";
    expect(folder, "cp d/response.csv " + csv + "; $ARDENT run " + csv + " --sidecar rig.toml -o " + name, 0, {});
    CHECK_THAT(support::bytes_of(folder / (std::string(name) + "/config.toml")),
               Catch::Contains("sidecar = \"../rig.toml\""));
    CHECK_THAT(support::bytes_of(folder / (std::string(name) + "/manifest.json")), Catch::Contains("../rig.toml"));
  }
  expect(folder, "$ARDENT info mon.csv tue.csv --sidecar rig.toml", 0, {"sidecar    rig.toml"});
  expect(folder, "$ARDENT check mon.csv --sidecar none.toml", 2, {"none.toml"});
}

TEST_CASE("a run folder holds every row, and less where that is asked for", "[apps][repeat]") {
  const Scratch folder;
  REQUIRE(support::run(folder, "$ARDENT sim duffing --duration 600 --noise 0.01 -o d").code == 0);
  const auto num_lines = [&](const std::string& name) {
    const std::string text = support::bytes_of(folder / name);
    return std::count(text.begin(), text.end(), '\n');
  };
  const auto has = [&](const std::string& name) { return fs::exists(folder / name); };
  expect(folder, "$ARDENT run d/response.csv -o r", 0, {});
  const auto quality = nlohmann::json::parse(support::bytes_of(folder / "r/quality.json"));
  CHECK(num_lines("r/prepared.csv") == 1 + quality["motion"][0]["num_samples"].get<std::ptrdiff_t>());
  const auto metrics = nlohmann::json::parse(support::bytes_of(folder / "r/metrics.json"));
  std::ptrdiff_t rows = 1;
  for (const auto& range : metrics["ranges"])
    rows += range["num_train"].get<std::ptrdiff_t>() + range["num_test"].get<std::ptrdiff_t>();
  CHECK(num_lines("r/predictions.csv") == rows);
  expect(folder, "$ARDENT fit r/prepared.csv --target a --terms x,v,x^3", 0, {"x^3"});
  expect(folder, "$ARDENT run r && $ARDENT report r && $ARDENT compare r r", 0, {"the same, bit for bit"});

  expect(folder, "$ARDENT run d/response.csv -o less --no-rows --no-figures", 0, {});
  for (const char* name : {"less/prepared.csv", "less/predictions.csv", "less/figures"}) CHECK_FALSE(has(name));
  CHECK(support::bytes_of(folder / "less/equation.json") == support::bytes_of(folder / "r/equation.json"));
  const std::string page = support::bytes_of(folder / "less/report.html");
  CHECK_THAT(page, Catch::Contains("free run on data not fitted") && !Catch::Contains("figures/"));
  expect(folder, "$ARDENT run less", 0, {"the same, bit for bit"});  // its config says what was left out
  CHECK_FALSE(has("less/figures"));
  expect(folder, "$ARDENT predict less d/response.csv -o p", 0, {});
  expect(folder, "$ARDENT frc less -o frc --set amplitude=0.001", 0, {});  // it needs no rows
  expect(folder, "$ARDENT run r --no-rows", 2, {"takes the run's own settings"});

  (void)folder.file("old.toml", "schema = 1\n[[recording]]\nfile = \"d/response.csv\"\n[output]\nfull = false\n");
  expect(folder, "$ARDENT run old.toml -o old", 0, {});  // of an earlier version
  CHECK(num_lines("old/prepared.csv") == num_lines("r/prepared.csv"));
}
