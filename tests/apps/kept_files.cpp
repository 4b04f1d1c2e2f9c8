// What a person has in or beside the place of the results, through the built program.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>

#include "support/program.hpp"
#include "support/staging.hpp"

namespace test_kept_files {

using support::bytes_of;
using support::expect;
using support::Scratch;
namespace fs = std::filesystem;

namespace {

/// A folder with a simulated Duffing oscillator and its run.
const Scratch& bench() {
  static const Scratch folder;
  static const bool made = [] {
    return support::run(folder, "$ARDENT -q sim duffing -o duffing --duration 4").code == 0 &&
           support::run(folder, "$ARDENT -q run duffing/response.csv -o base").code == 0;
  }();
  REQUIRE(made);
  return folder;
}

const std::string frc = "frc base --draws 0 --set amplitude=1 --set from_hz=1 --set to_hz=1.1 --set step_hz=0.1";
const std::string study = "study duffing/response.csv --over order=1";
/// Every command that writes a folder.
const std::vector<std::string> commands{"run duffing/response.csv",
                                        "prep duffing/response.csv",
                                        "sim coulomb",
                                        "sim qzs --frc --set from_hz=1.4 --set to_hz=1.42 --set dwell_s=5",
                                        frc,
                                        study,
                                        "replicate fig-3"};

std::map<std::string, std::string> files_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    files[entry.path().lexically_relative(folder).string()] = entry.is_regular_file() ? bytes_of(entry.path()) : "";
  return files;
}

}  // namespace

TEST_CASE("a simulation does not take the place of a person's own files", "[apps][kept_files]") {
  const Scratch folder;
  fs::create_directory(folder / "mine");
  for (const char* name :
       {"mine/recording.wav", "mine/recording.wav.toml", "mine/response.csv", "mine/truth.csv", "mine/recording.flac"})
    (void)folder.file(name, "measured");
  const auto before = files_in(folder / "mine");
  for (const char* force : {"", " --force"}) {
    expect(folder, std::string("$ARDENT sim duffing -o mine") + force, 5, {"[output.foreign] mine", "-o"});
    expect(folder, std::string("$ARDENT sim qzs --raw --duration 1 -o mine") + force, 5, {"[output.foreign] mine"});
  }
  (void)folder.file("mine/truth.json", "{}");
  expect(folder, "$ARDENT sim duffing -o mine --force", 5, {"[output.foreign] mine"});
  fs::remove(folder / "mine/truth.json");
  CHECK(files_in(folder / "mine") == before);
}

TEST_CASE("a lock file of another program beside the results is left alone", "[apps][kept_files]") {
  const Scratch& folder = bench();
  for (const char* name : {"yarn.lock", "base.lock"}) (void)folder.file(name, "# yarn");
  expect(folder, "$ARDENT run duffing/response.csv -o yarn", 0, {});
  expect(folder, "$ARDENT run duffing/response.csv -o base", 5, {"[output.exists]"});
  for (const char* name : {"yarn.lock", "base.lock"}) CHECK(bytes_of(folder / name) == "# yarn");
}

TEST_CASE("what a person called X.partial is left alone", "[apps][kept_files]") {
  const Scratch& folder = bench();
  (void)folder.file("file.partial", "half a film");
  fs::create_directory(folder / "folder.partial");
  (void)folder.file("folder.partial/a", "half a film");
  for (const std::string name : {"file", "folder"})
    expect(folder, "$ARDENT run duffing/response.csv --force -o " + name, 0, {});
  CHECK(bytes_of(folder / "file.partial") == "half a film");
  CHECK(bytes_of(folder / "folder.partial/a") == "half a film");
}

TEST_CASE("what --force replaces is what a manifest of Ardent's lists and nothing else", "[apps][kept_files]") {
  const Scratch& folder = bench();
  fs::create_directory(folder / "npm");
  (void)folder.file("npm/manifest.json", R"({"name": "site", "authors": ["ardent"]})");
  (void)folder.file("npm/index.html", "mine");
  for (const std::string& command : commands) {
    expect(folder, "$ARDENT --force -o npm " + command, 5, {"[output.foreign] npm: holds files but no manifest"});
    expect(folder, "$ARDENT -q -o again " + command, 0, {});
    expect(folder, "$ARDENT -q -o again " + command, 5, {"[output.exists] again", "--force"});
    (void)folder.file("again/notes.txt", "mine");
    expect(folder, "$ARDENT -q --force -o again " + command, 5, {"[output.foreign] again/notes.txt"});
    CHECK(bytes_of(folder / "again/notes.txt") == "mine");
    fs::remove(folder / "again/notes.txt");
    expect(folder, "$ARDENT -q --force -o again " + command, 0, {});
    fs::remove_all(folder / "again");
  }
  CHECK(bytes_of(folder / "npm/index.html") == "mine");
}

TEST_CASE("two commands do not write into one folder at a time", "[apps][kept_files]") {
  const Scratch& folder = bench();
  support::Running first(folder / "", "exec $ARDENT -q sim qzs --raw --duration 1000 -o shared");
  CHECK(support::eventually([&] { return fs::exists(support::staging_of(folder / "shared") / "new/shared"); }));
  for (const std::string& command : commands)
    expect(folder, "$ARDENT --force -o shared " + command, 5, {"[output.locked] shared"});
  first.send(SIGTERM);
  CHECK(first.wait().code == 128 + SIGTERM);
  CHECK_FALSE(fs::exists(folder / "shared"));
  CHECK_FALSE(fs::exists(support::staging_of(folder / "shared")));
}

TEST_CASE("an old simulation stays until the new one is whole", "[apps][kept_files]") {
  const Scratch& folder = bench();
  REQUIRE(support::run(folder, "$ARDENT -q sim duffing -o kept").code == 0);
  const auto before = files_in(folder / "kept");
  for (const int signal : {SIGINT, SIGKILL}) {
    support::Running running(folder / "", "exec $ARDENT -q sim qzs --raw --duration 1000 -o kept --force");
    CHECK(support::eventually([&] {
      std::error_code not_yet;
      const bool is_empty = fs::is_empty(support::staging_of(folder / "kept") / "new/kept", not_yet);
      return !not_yet && !is_empty;
    }));
    running.send(signal);
    CHECK(running.wait().code == 128 + signal);
    CHECK(files_in(folder / "kept") == before);
    CHECK(fs::exists(support::staging_of(folder / "kept")) == (signal == SIGKILL));
  }
  expect(folder, "$ARDENT -q sim coulomb -o kept --force", 0, {});
  CHECK_FALSE(fs::exists(support::staging_of(folder / "kept")));
}

TEST_CASE("where there is no room for all of the new results the old ones stay as they are", "[apps][kept_files]") {
  const Scratch& folder = bench();
  for (const std::string& command : commands) {
    CAPTURE(command);
    REQUIRE(support::run(folder, "$ARDENT -q -o full " + command).code == 0);
    const auto before = files_in(folder / "full");
    std::uintmax_t largest = 0;
    for (const auto& [name, bytes] : before) largest = std::max<std::uintmax_t>(largest, bytes.size());
    // ulimit counts blocks of 512 bytes: all but the largest file fit.
    const std::string limit = "ulimit -f " + std::to_string((largest - 1) / 512) + "; ";
    expect(folder, limit + "$ARDENT -q --force -o full " + command, 5, {"[output.write] full/", "File too large"});
    CHECK(files_in(folder / "full") == before);
    CHECK_FALSE(fs::exists(support::staging_of(folder / "full")));
    fs::remove_all(folder / "full");
  }
}

#ifndef ARDENT_SANITIZED  // the sanitizers replace the same calls
TEST_CASE("an error of any write of a recording, its header last, is seen", "[apps][kept_files]") {
  const Scratch& folder = bench();
  const std::string sim =
      "$ARDENT -q -o raw sim qzs --raw --duration 0.1 --programme decay --set releases=1 --set dwell_s=8 --container ";
  for (const std::string container : {"wav", "caf"}) {
    REQUIRE(support::run(folder, "ARDENT_COUNTS=counts LD_PRELOAD=" ARDENT_FAILING_CALLS " " + sim + container).code ==
            0);
    fs::remove_all(folder / "raw");
    const int num_writes = std::stoi(bytes_of(folder / "counts"));
    for (int n = 1; n <= num_writes; ++n) {
      CAPTURE(container, n);
      expect(folder, fmt::format("ARDENT_FAIL=write:{} LD_PRELOAD=" ARDENT_FAILING_CALLS " {}{}", n, sim, container), 5,
             {"[output.write] raw", "No space left"});
      CHECK_FALSE(fs::exists(folder / "raw"));
    }
  }
}
TEST_CASE("a killed init leaves nothing that the next one does not clear, and no init overwrites unasked",
          "[apps][kept_files]") {
  const Scratch folder;
  fs::create_directory(folder / "place");
  fs::copy(bench() / "duffing/response.csv", folder / "place/a.csv");
  // Killed with half of a file written.
  const std::string killed = "ARDENT_AT=write:1 ARDENT_DO='kill -9 $PPID' LD_PRELOAD=" ARDENT_FAILING_CALLS " ";
  CHECK(support::run(folder, killed + "$ARDENT init place/a.csv").code == 128 + SIGKILL);
  CHECK(fs::exists(support::staging_of(folder / "place/a.csv.toml") / "new/a.csv.toml"));
  const auto names = [&] {
    std::vector<std::string> all;
    for (const auto& [name, bytes] : files_in(folder / "place")) all.push_back(name);
    return all;
  };
  expect(folder, "$ARDENT init place/a.csv", 0, {"wrote place/a.csv.toml and place/a.toml"});
  CHECK(names() == std::vector<std::string>{"a.csv", "a.csv.toml", "a.toml"});
  fs::remove(folder / "place/a.csv.toml");
  (void)folder.file("place/a.toml", "mine");
  expect(folder, "$ARDENT init place/a.csv", 5, {"[output.exists] place/a.toml"});
  CHECK(names() == std::vector<std::string>{"a.csv", "a.toml"});
  expect(folder, "$ARDENT init place/a.csv --force", 0, {});
  CHECK(names() == std::vector<std::string>{"a.csv", "a.csv.toml", "a.toml"});
  CHECK(bytes_of(folder / "place/a.toml") != "mine");
}
#endif

TEST_CASE("a manifest does not say where a person keeps the recording", "[apps][kept_files]") {
  const Scratch folder;
  fs::create_directories(folder / "home/joe/secret");
  fs::create_directories(folder / "work/project");
  fs::copy(bench() / "duffing/response.csv", folder / "home/joe/secret/x.csv");
  for (const std::string& input :
       {std::string("../../home/joe/secret/x.csv"), (folder / "home/joe/secret/x.csv").string()}) {
    expect(folder, "cd work/project && $ARDENT -q --force run " + input + " -o run", 0, {});
    const std::string manifest = bytes_of(folder / "work/project/run/manifest.json");
    CHECK_THAT(manifest, !Catch::Contains("joe") && !Catch::Contains("..") && Catch::Contains("\"x.csv\""));
  }
  expect(folder, "cd work/project && $ARDENT -q run run/config.toml -o again", 0, {});
  CHECK(bytes_of(folder / "work/project/again/prepared.csv") == bytes_of(folder / "work/project/run/prepared.csv"));
}

TEST_CASE("the current folder is not replaced", "[apps][kept_files]") {
  const Scratch& folder = bench();
  fs::create_directory(folder / "here");
  expect(folder, "cd here && $ARDENT sim duffing -o .", 2, {"[output.current] .: is the current folder", "-o results"});
  CHECK(fs::is_empty(folder / "here"));
}

}  // namespace test_kept_files
