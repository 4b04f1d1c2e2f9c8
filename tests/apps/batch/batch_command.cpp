#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/batch/record_results.hpp"
#include "apps/process/sha256.hpp"
#include "support/program.hpp"

namespace fs = std::filesystem;
using nlohmann::json;
using support::bytes_of;
using support::expect;
using support::Scratch;

namespace {

constexpr const char* config = "schema = 1\n[library]\norder = 2\n[fit]\nmethods = [\"fast_rvm\", \"ols\"]\n";

/// c.toml and recordings r1.csv, r2.csv, ...
std::string make_recordings(const Scratch& folder, int count, int duration_s = 15, int step_s = 1) {
  (void)folder.file("c.toml", config);
  std::string names;
  for (int i = 1; i <= count; ++i) {
    const std::string name = "r" + std::to_string(i);
    REQUIRE(support::run(folder, "$ARDENT sim duffing --noise 0.01 --duration " +
                                     std::to_string(duration_s + i * step_s) + " --seed " + std::to_string(i) +
                                     " -o s && cp s/response.csv " + name + ".csv && rm -r s")
                .code == 0);
    names += " " + name + ".csv";
  }
  return names;
}

/// Hash of every file of a batch by its path, but of those with times in them.
std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file() && name != "log.txt" && name != "manifest.json")
      files[entry.path().lexically_relative(folder).string()] = apps::sha256(bytes_of(entry.path())).substr(0, 8);
  }
  return files;
}

/// Children of a process, by the system.
std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = bytes_of(entry.path() / "stat");
    const auto behind = stat.rfind(')');
    pid_t its_parent = 0;
    if (behind != std::string::npos && std::sscanf(stat.c_str() + behind, ") %*c %d", &its_parent) == 1 &&
        its_parent == parent)
      found.push_back(std::stoi(name));
  }
  return found;
}

bool has_mpirun() {
  const Scratch folder;
  return support::run(folder, "command -v mpirun").code == 0;
}

const std::string mpirun = "mpirun --allow-run-as-root --oversubscribe --bind-to none -n 3 ";

}  // namespace

TEST_CASE("a recording that cannot be read costs a batch that recording", "[apps][batch_command]") {
  const Scratch folder;
  const std::string names = make_recordings(folder, 2);
  (void)folder.file("bad.csv", "t,x,v,a,f\n0,1,2,3,nonsense\n");
  const auto ended =
      expect(folder, "$ARDENT batch c.toml bad.csv gone.csv" + names + " -o out", 3,
             {"4 records: 2 with results", "bad.csv: [", "gone.csv: [file.missing]", "out: open report.html"});
  const json table = json::parse(bytes_of(folder / "out/table.json"));
  REQUIRE(table["records"].size() == 4);
  CHECK(table["num_failed"] == 2);
  CHECK(table["records"][0]["exit_code"] == 3);
  CHECK(table["records"][0]["run"].is_null());
  CHECK(table["records"][2]["run"] == "runs/r1");
  CHECK(table["records"][2]["error"].is_null());
  CHECK(table["records"][2]["ranges"][0]["chosen"] == true);
  CHECK(table["joint"]["ranges"][0]["records"].size() == 2);
  const std::string csv = bytes_of(folder / "out/table.csv");
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 5);
  const std::string page = bytes_of(folder / "out/report.html");
  CHECK_THAT(page, Catch::Contains("runs/r1/report.html") && Catch::Contains("What went wrong") &&
                       !Catch::Contains("href=\"http") && !Catch::Contains("src="));
  // The runs are what `ardent run` gives, bit for bit, and can be repeated from their folders.
  expect(folder, "$ARDENT run c.toml r1.csv -o out2/runs/r1", 0, {});
  CHECK(files_of(folder / "out2/runs/r1") == files_of(folder / "out/runs/r1"));
  expect(folder, "$ARDENT run out/runs/r1", 0, {});
}

TEST_CASE("a row of a batch has the equation whose verdict it has", "[apps][batch_command]") {
  const Scratch folder;
  (void)make_recordings(folder, 1);
  expect(folder, "$ARDENT -q run c.toml r1.csv -o runs/r1 --set 'fit.methods=[\"ols\",\"fast_rvm\"]'", 0, {});
  json document = json::parse(bytes_of(folder / "runs/r1/equation.json"));
  json& range = document["ranges"][0];
  range["methods"][0]["verdict"] = "undecided";  // both have the same here
  const json ols = range["methods"][0], fast_rvm = range["methods"][1];
  REQUIRE(fast_rvm["verdict"] != "undecided");
  CHECK(range["method"] == "fast_rvm");
  CHECK(range["verdict"] == fast_rvm["verdict"]);
  const auto row = [&] {
    (void)folder.file("runs/r1/equation.json", document.dump());
    const apps::RecordTask task{.recording = "r1.csv", .called = "r1.csv", .name = "r1"};
    return apps::record_result(task, {.has_run = true}, folder / "runs", "").ranges.at(0);
  };
  const auto check_row_of = [&](const json& fit) {
    CHECK(row().at("method").get<std::string>() == fit["method"]);
    CHECK(row().at("equation").get<std::string>() == fit["text"]);
    CHECK(row().at("verdict").get<std::string>() == fit["verdict"]);
  };
  check_row_of(fast_rvm);
  range["method"] = "ols";  // as where fast_rvm has no equation
  check_row_of(ols);
  range.erase("method");  // as an earlier version wrote it
  check_row_of(fast_rvm);
}

TEST_CASE("a batch has the same bytes however many do it", "[apps][batch_command]") {
  const Scratch folder;
  const std::string names = make_recordings(folder, 4);
  expect(folder, "$ARDENT -q batch c.toml" + names + " -o one --jobs 1 --threads 1", 0, {});
  expect(folder, "$ARDENT -q batch c.toml" + names + " -o three --jobs 3 --threads 2", 0, {});
  const auto one = files_of(folder / "one");
  CHECK(one.size() > 40);
  CHECK(one == files_of(folder / "three"));
  if (!has_mpirun()) {
    WARN("skipped: there is no mpirun");
    return;
  }
  expect(folder, mpirun + ("$ARDENT -q batch c.toml" + names) + " -o ranks", 0, {});
  CHECK(one == files_of(folder / "ranks"));
  // What is wrong is said once, and nobody waits for ever.
  const auto ended = support::run(folder, mpirun + ("$ARDENT batch c.toml r1.csv r1.csv") + " -o twice");
  CHECK(ended.code == 2);
  CHECK(ended.err.find("[batch.twice]") == ended.err.rfind("[batch.twice]"));
}

TEST_CASE("a batch that begins again does what is missing or has changed", "[apps][batch_command]") {
  const Scratch folder;
  const std::string batch = "$ARDENT batch c.toml" + make_recordings(folder, 3) + " -o out --jobs 2 --threads 1 ";
  expect(folder, batch, 0, {});
  const auto manifests = [&] {
    std::vector<std::string> all;
    for (const char* name : {"r1", "r2", "r3"})
      all.push_back(bytes_of(folder / ("out/runs/" + std::string(name) + "/manifest.json")));
    return all;
  };
  const auto before = manifests();
  const std::string table = bytes_of(folder / "out/table.csv");
  expect(folder, batch, 0, {"3 kept from before"});
  CHECK(manifests() == before);
  CHECK(bytes_of(folder / "out/table.csv") == table);

  expect(folder, "sed -i '$ s/.$/1/' r2.csv; rm -r out/runs/r3; " + batch, 0, {"1 kept from before"});
  auto after = manifests();
  CHECK(after[0] == before[0]);
  CHECK(after[1] != before[1]);
  expect(folder, "echo '# a remark' >> c.toml; " + batch, 0, {"open report.html"});
  CHECK(manifests()[0] != before[0]);
  expect(folder, batch + "--set library.order=1", 0, {});
  CHECK(bytes_of(folder / "out/table.csv") != table);
  after = manifests();
  expect(folder, batch + "--set library.order=1 --force", 0, {});
  CHECK(manifests()[0] != after[0]);
  expect(folder, batch + "--no-rows --no-figures", 0, {});
  for (const std::string name : {"prepared.csv", "predictions.csv", "figures"})
    CHECK_FALSE(fs::exists(folder / ("out/runs/r1/" + name)));

  // What a person put there stays, and costs its record only.
  (void)folder.file("out/runs/r1/note.txt", "mine");
  expect(folder, batch, 5, {"r1.csv: [output.foreign]", "3 records: 2 with results"});
  CHECK(fs::exists(folder / "out/runs/r1/note.txt"));
  (void)folder.file("out/table.csv", "mine");
  expect(folder, batch, 5, {"[output.foreign] out/table.csv"});
  CHECK(bytes_of(folder / "out/table.csv") == "mine");
}

TEST_CASE("kill -9 of a batch, of its children or of a rank loses nothing and nothing is done twice",
          "[apps][batch_command]") {
  const Scratch folder;
  const std::string names = make_recordings(folder, 6, 0, 60);                    // the longest is begun first
  (void)folder.file("c.toml", std::string(config) + "stage = \"regression\"\n");  // the quicker one: it is not at stake
  expect(folder, "$ARDENT -q batch c.toml" + names + " -o whole --jobs 2 --threads 1", 0, {});
  const auto wanted = files_of(folder / "whole");
  const auto done = [&](const std::string& out) {
    std::map<std::string, std::string> manifests;
    if (fs::exists(folder / (out + "/runs")))
      for (const auto& entry : fs::directory_iterator(folder / (out + "/runs")))
        if (entry.path().filename().string().front() != '.' && fs::exists(entry.path() / "manifest.json"))
          manifests[entry.path().filename().string()] = bytes_of(entry.path() / "manifest.json");
    return manifests;
  };
  const auto check_resumed = [&](const std::string& out, const std::string& command,
                                 const std::map<std::string, std::string>& before) {
    CHECK_FALSE(fs::exists(folder / (out + "/manifest.json")));
    expect(folder, command, 0, {});
    CHECK(files_of(folder / out) == wanted);
    const auto after = done(out);
    CHECK(after.size() == 6);
    for (const auto& [name, manifest] : before) CHECK(after.at(name) == manifest);  // not done twice
  };

  SECTION("the whole, at several moments") {
    for (const std::size_t moment : {0u, 1u, 3u}) {
      const std::string out = "out" + std::to_string(moment);
      const std::string command = "exec $ARDENT -q batch c.toml" + names + " -o " + out + " --jobs 2 --threads 1";
      support::Running running(folder / "", command);
      REQUIRE(support::eventually([&] { return fs::exists(folder / (out + "/runs")) && done(out).size() >= moment; }));
      running.send(SIGKILL);
      CHECK(running.wait().code == 128 + SIGKILL);
      check_resumed(out, command, done(out));
    }
  }
  SECTION("one child") {
    const std::string command = "exec $ARDENT batch c.toml" + names + " -o out --jobs 1 --threads 1";
    for (const auto& [signal, name, code] :
         {std::tuple{SIGKILL, "[task.killed]", 4}, std::tuple{SIGSEGV, "[task.crashed]", 1}}) {
      support::Running running(folder / "", command);
      std::vector<pid_t> children;
      REQUIRE(support::eventually([&] { return !(children = children_of(running.pid())).empty(); }));
      ::kill(children.front(), signal);
      const auto ended = running.wait();
      CAPTURE(ended.err);
      CHECK(ended.code == code);
      CHECK_THAT(ended.out, Catch::Contains(name) && Catch::Contains("6 records: 5 with results"));
      fs::rename(folder / "out", folder / ("stopped" + std::to_string(code)));
    }
    fs::rename(folder / "stopped1", folder / "out");
    const auto before = done("out");
    CHECK(before.size() == 5);
    expect(folder, command, 0, {"5 kept from before"});
    CHECK(files_of(folder / "out") == wanted);
  }
  SECTION("one rank") {
    if (!has_mpirun()) {
      WARN("skipped: there is no mpirun");
      return;
    }
    const std::string command = "exec " + mpirun + "$ARDENT -q batch c.toml" + names + " -o out";
    support::Running running(folder / "", command);
    std::vector<pid_t> ranks;
    REQUIRE(support::eventually([&] { return done("out").size() >= 1; }));
    ranks = children_of(running.pid());
    REQUIRE(ranks.size() == 3);
    ::kill(ranks.back(), SIGKILL);
    CHECK(running.wait().code != 0);
    check_resumed("out", command, done("out"));
  }
}

TEST_CASE("a batch needs no config: each recording is run as by itself", "[apps][batch_command]") {
  const Scratch folder;
  const std::string names = make_recordings(folder, 2);
  expect(folder, "$ARDENT -q batch" + names + " -o out", 0, {"2 records: 2 with results"});
  expect(folder, "$ARDENT -q run r2.csv -o own", 0, {});
  CHECK(bytes_of(folder / "out/runs/r2/equation.json") == bytes_of(folder / "own/equation.json"));
  CHECK(bytes_of(folder / "out/runs/r2/config.toml") != "");
  CHECK_THAT(bytes_of(folder / "out/report.html"), Catch::Contains("<h1>2 records</h1>"));
  expect(folder, "$ARDENT -q batch" + names + " -o out", 0, {"2 kept from before"});
  // What one recording leaves out of the summary is not lost in silence.
  const std::string table = bytes_of(folder / "out/table.csv");
  expect(folder, "$ARDENT -q batch r1.csv -o out", 5, {"[batch.others]", "1 run of recordings", "(r2)"});
  CHECK(bytes_of(folder / "out/table.csv") == table);
  expect(folder, "$ARDENT -q batch r1.csv -o out --force", 0, {"1 records: 1 with results"});
}

TEST_CASE("a batch refuses what is no place for it, and says what it would do", "[apps][batch_command]") {
  const Scratch folder;
  const std::string names = make_recordings(folder, 1);
  expect(folder, "$ARDENT batch c.toml" + names, 2, {"-o DIR is missing"});
  expect(folder, "$ARDENT batch r1.csv ./r1.csv -o out", 2, {"is given twice, also as"});
  expect(folder, "$ARDENT batch c.toml -o out", 2, {"want recordings after the config"});
  expect(folder, "$ARDENT batch r1.csv c.toml -o out", 2, {"c.toml: want one config, before the recordings"});
  expect(folder, "$ARDENT batch c.toml" + names + " -o out --set library.order=-1", 2, {"[config.range]"});
  expect(folder, "$ARDENT batch c.toml" + names + " -o . ", 2, {"[output.overlap]"});
  expect(folder, "mkdir here && cd here && $ARDENT batch ../c.toml ../r1.csv -o .", 2, {"[output.current]"});
  expect(folder, "mkdir d && cp r1.csv d && $ARDENT batch c.toml d/r1.csv -o d", 2, {"[output.overlap]"});
  expect(folder, "mkdir mine && touch mine/note && $ARDENT batch c.toml" + names + " -o mine", 5, {"[output.foreign]"});
  expect(folder, "$ARDENT sim duffing -o s && $ARDENT batch c.toml" + names + " -o s --force", 5, {"[output.foreign]"});
  expect(folder, "$ARDENT batch c.toml" + names + " -o out --dry-run", 0, {"r1.csv -> out/runs/r1"});
  CHECK_FALSE(fs::exists(folder / "out"));
  // A verdict that is required costs the exit code only.
  expect(folder,
         "$ARDENT batch c.toml" + names + " -o out --set library.order=1 --set library.terms=[] --require describes", 4,
         {"r1.csv: [verdict.required]"});
  CHECK(fs::exists(folder / "out/manifest.json"));
  CHECK(fs::exists(folder / "out/runs/r1/manifest.json"));
  expect(folder, "OMPI_COMM_WORLD_SIZE=2 $ARDENT batch c.toml" + names + " -o out3", 2, {"[batch.mpi]"});
}
