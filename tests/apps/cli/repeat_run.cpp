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

TEST_CASE("a run folder is no larger than its recording or 10 MB, unless asked", "[apps][repeat]") {
  const Scratch folder;
  REQUIRE(support::run(folder, "$ARDENT sim duffing --duration 600 --noise 0.01 -o d").code == 0);
  const auto size_of = [&](const char* name) {
    double bytes = 0.0;
    for (const auto& entry : fs::recursive_directory_iterator(folder / name))
      if (entry.is_regular_file()) bytes += static_cast<double>(entry.file_size());
    return bytes;
  };
  const double limit = std::max(10e6, static_cast<double>(fs::file_size(folder / "d/response.csv")));
  expect(folder, "$ARDENT run d/response.csv -o r", 0, {});
  CAPTURE(size_of("r"), limit);
  CHECK(size_of("r") <= limit);
  CHECK(size_of("r") > 0.3 * limit);  // and no emptier than need be
  CHECK(fs::exists(folder / "r/prepared.csv.gz"));
  CHECK_FALSE(fs::exists(folder / "r/prepared.csv"));
  CHECK_THAT(support::bytes_of(folder / "r/log.txt"), Catch::Contains("prepared.csv.gz: "));
  expect(folder, "gzip -t r/*.gz && gzip -dc r/prepared.csv.gz | head -2", 0, {"t,y,x,v,a"});
  expect(folder, "$ARDENT run r && $ARDENT report r && $ARDENT compare r r", 0, {"the same, bit for bit"});
  expect(folder, "$ARDENT run d/response.csv -o full --full", 0, {});
  CHECK(fs::exists(folder / "full/prepared.csv"));
  CHECK(size_of("full") > limit);
  expect(folder, "$ARDENT run full", 0, {});  // its config says that it was asked
}
