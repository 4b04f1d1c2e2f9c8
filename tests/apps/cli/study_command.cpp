#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "support/program.hpp"

namespace test_cli_study_command {

using nlohmann::json;
using support::Scratch;

namespace {

/// A folder with a simulated Duffing oscillator and a config for it.
const Scratch& bench() {
  static const Scratch folder;
  static const support::Ended made = support::run(folder, "$ARDENT sim duffing -o duffing --noise 0.02");
  REQUIRE(made.code == 0);
  (void)folder.file("duffing.toml",
                    "schema = 1\n[[recording]]\nfile = \"duffing/response.csv\"\n[prepare]\ncutoff_hz = 20\nrolloff_hz "
                    "= 16\n[library]\norder = 3\nterms = [\"f\"]\n[fit]\nmethods = [\"fast_rvm\", \"sindy\"]\n");
  return folder;
}

/// The fits of the first range of a run's metrics.json, in the form of a study's cells.
json fits_of(const Scratch& folder, const std::string& run) {
  return json::parse(support::bytes_of(folder / (run + "/metrics.json")))["ranges"][0]["methods"];
}

void check_same(const json& cell, const json& fit) {
  CAPTURE(cell["setting"].dump(), cell["method"].dump());
  CHECK(cell["method"] == fit["method"]);
  for (const char* key : {"train", "test", "free_run"}) CHECK(cell["nmse"][key] == fit["nmse"][key]);
  REQUIRE(cell["terms"].size() == fit["terms"].size());
  for (std::size_t i = 0; i < fit["terms"].size(); ++i)
    for (const char* key : {"name", "mean", "std"}) CHECK(cell["terms"][i][key] == fit["terms"][i][key]);
}

}  // namespace

TEST_CASE("every cell of a study is a run with its settings", "[apps][study_command]") {
  const Scratch& folder = bench();
  const auto ended = support::run(folder,
                                  "$ARDENT study duffing.toml -o study --over order=2,3 --over cutoff_hz=10,20 "
                                  "--over train_share=0.4 --over tau=60");
  CAPTURE(ended.err);
  REQUIRE(ended.code == 0);
  for (const char* name : {"study.txt", "study.csv", "study.svg"})
    CHECK(std::filesystem::exists(folder / ("study/" + std::string(name))) == (std::string(name) != "study.svg"));
  const json cells = json::parse(support::bytes_of(folder / "study/study.json"))["cells"];
  REQUIRE(cells.size() == 2 * (1 + 2 + 2 + 1) + 1);  // tau is no affair of sindy's

  const std::map<std::string, std::string> runs{
      {"{}", ""},
      {"{\"library.order\":\"2\"}", "--set library.order=2"},
      {"{\"prepare.cutoff_hz\":\"10\"}", "--set prepare.cutoff_hz=10 --set prepare.rolloff_hz=8"},
      {"{\"fit.train_share\":\"0.4\"}", "--set fit.train_share=0.4"},
      {"{\"fit.tau\":\"60\"}", "--set fit.tau=60"}};
  std::size_t compared = 0;
  for (const auto& [setting, options] : runs) {
    CAPTURE(setting);
    REQUIRE(support::run(folder, "$ARDENT --force run duffing.toml -o alone " + options).code == 0);
    const json fits = fits_of(folder, "alone");
    for (const json& cell : cells) {
      if (cell["setting"].dump() != setting) continue;
      check_same(cell, cell["method"] == "fast_rvm" ? fits[0] : fits[1]);
      ++compared;
    }
  }
  CHECK(compared == 2 * 4 + 1);
  CHECK_THAT(ended.out, Catch::Contains("kept in how many of 7 settings") && Catch::Contains("x^3"));
}

TEST_CASE("a setting of a method is varied for the methods that have it only", "[apps][study_command]") {
  const Scratch& folder = bench();
  const auto ended = support::run(
      folder, "$ARDENT --json study duffing.toml -o settings --over threshold_on=raw --over ridge_lambda=1");
  REQUIRE(ended.code == 0);
  const json document = json::parse(ended.out);
  std::map<std::string, int> methods;  // of fast_rvm and sindy; nobody here has ridge_lambda
  for (const json& cell : document["cells"])
    if (cell["setting"].contains("fit.threshold_on")) ++methods[cell["method"]];
  CHECK(methods == std::map<std::string, int>{{"sindy", 1}});
}

TEST_CASE("a study may be in the config, and be a grid", "[apps][study_command]") {
  const Scratch& folder = bench();
  (void)folder.file("own.toml", support::bytes_of(folder / "duffing.toml") +
                                    "[study]\norder = [1, 3]\nselection = [\"evidence\", \"type2\"]\n");
  const auto ended = support::run(folder, "$ARDENT --json study own.toml -o own --grid");
  REQUIRE(ended.code == 0);
  const json document = json::parse(ended.out);
  CHECK(document["axes"].size() == 2);
  CHECK(document["cells"].size() == 2 * 2 * 2);
  std::size_t few = 0, many = 0;
  for (const json& cell : document["cells"])
    (cell["setting"]["library.order"] == "1" ? few : many) += cell["terms"].size();
  CHECK(few < many);
  CHECK(support::run(folder, "$ARDENT run own.toml -o own-run").code == 0);  // a run takes no notice of [study]
}

TEST_CASE("what is wrong with a study is said before anything is read", "[apps][study_command]") {
  const Scratch& folder = bench();
  const auto expect = [&](const std::string& command, int code, const std::string& piece) {
    CAPTURE(command);
    const auto ended = support::run(folder, "$ARDENT study " + command);
    CHECK(ended.code == code);
    CHECK_THAT(ended.err, Catch::Contains(piece));
  };
  expect("duffing.toml -o bad --over speed=1", 2, "study.over");
  expect("duffing.toml -o bad --over order=many", 2, "library.order");
  expect("duffing.toml -o bad --over train_share=0", 2, "train_share");
  expect("nothing.csv -o bad", 3, "nothing.csv");
  expect("duffing.toml -o duffing", 2, "output.overlap");
  CHECK_FALSE(std::filesystem::exists(folder / "bad"));
  CHECK(support::run(folder, "$ARDENT study duffing.toml -o twice --over order=1").code == 0);
  expect("duffing.toml -o twice --over order=1", 5, "output.exists");
  expect("duffing.toml -o twice --over order=1 --force", 0, "order=1");
  (void)folder.file("odd.toml", support::bytes_of(folder / "duffing.toml") + "[study]\nspeed = [1]\n");
  expect("odd.toml -o bad", 2, "Known here: cutoff_hz");
  const auto plan = support::run(folder, "$ARDENT --dry-run study duffing.toml -o bad --over order=1,2");
  CHECK(plan.code == 0);
  CHECK_THAT(plan.out, Catch::Contains("library.order=2") && Catch::Contains("would write bad"));
  CHECK_FALSE(std::filesystem::exists(folder / "bad"));
}

TEST_CASE("what numerics end is one cell's trouble, what is wrong with a cell ends the study",
          "[apps][study_command]") {
  const Scratch& folder = bench();
  const auto ended =
      support::run(folder, "$ARDENT --json study duffing.toml -o memory --over order=3,20 --max-memory 3");
  CHECK(ended.code == 0);
  std::size_t fits = 0, troubles = 0;
  const json document = json::parse(ended.out);
  for (const json& cell : document["cells"]) {
    if (cell["range"].is_string()) {
      ++fits;
      continue;
    }
    ++troubles;
    CHECK(cell["setting"]["library.order"] == "20");
    CHECK_THAT(cell["reason"].get<std::string>(), Catch::Contains("response.csv: needs"));
  }
  CHECK(fits == 2 * 2);
  CHECK(troubles == 1);
  support::expect(folder, "$ARDENT study duffing.toml -o wrong --over 'library.terms=[\"f\"],[\"z\"]'", 2,
                  {"[term.unknown_name]", "'z' is not known here"});
  CHECK_FALSE(std::filesystem::exists(folder / "wrong"));
}

}  // namespace test_cli_study_command
