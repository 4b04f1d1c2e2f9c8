// Links, look-alikes and mounts that came with somebody's data, or come while a command runs: whatever lies behind them
// stays. Through the built program.
#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <map>
#include <sstream>

#include "support/program.hpp"
#include "support/staging.hpp"

namespace test_planted_files {

using support::bytes_of;
using support::expect;
using support::Scratch;
namespace fs = std::filesystem;

namespace {

/// A command, where it writes, and whether that can be given with -o.
struct Command {
  std::string line, place;
};

/// Every command that writes.
const std::vector<Command> commands{
    {"run duffing/response.csv", "out"},
    {"prep duffing/response.csv", "out"},
    {"sim duffing --duration 0.2", "out"},
    {"sim qzs --frc --set from_hz=1.4 --set to_hz=1.42 --set dwell_s=5", "out"},
    {"frc base --draws 0 --set amplitude=1 --set from_hz=1 --set to_hz=1.1 --set step_hz=0.1", "out"},
    {"predict base duffing/response.csv", "out"},
    {"compare base base2", "out"},
    {"study duffing/response.csv --over order=1 --set 'fit.methods=[\"fast_rvm\"]'", "out"},
    {"replicate fig-3", "out"},
    {"manual", "out"},
    {"batch c.toml duffing/response.csv --jobs 1", "out/summary"},
    {"init a.csv", "out/a.csv.toml"},
    {"merge base/factors.json --save out/both.json", "out/both.json"}};

/// Inputs of the commands, and what may not be touched.
const Scratch& bench() {
  static const Scratch folder;
  static const bool made = [] {
    (void)folder.file("c.toml", "");
    fs::create_directories(folder / "victim/docs");
    (void)folder.file("victim/b", "mine");
    (void)folder.file("victim/docs/a", "mine");
    return support::run(folder,
                        "$ARDENT -q sim duffing -o duffing --duration 4 && cp duffing/response.csv a.csv && "
                        "$ARDENT -q run duffing/response.csv -o base && cp -r base base2")
               .code == 0;
  }();
  REQUIRE(made);
  return folder;
}

std::string line_of(const Command& command) {
  const bool takes_place = command.line.find("--save") == std::string::npos;
  return fmt::format("$ARDENT -q {}{}", command.line, takes_place ? " -o out" : "");
}

std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    all[entry.path().string()] = entry.is_symlink()        ? fs::read_symlink(entry.path()).string()
                                 : entry.is_regular_file() ? bytes_of(entry.path())
                                                           : "";
  return all;
}

void check_victim(const Scratch& folder) {
  CHECK(bytes_of(folder / "victim/b") == "mine");
  CHECK(bytes_of(folder / "victim/docs/a") == "mine");
}

}  // namespace

TEST_CASE("a clone with a planted staging folder loses nothing around it", "[apps][planted_files]") {
  const Scratch folder;
  fs::create_directories(folder / "up/docs");
  (void)folder.file("up/docs/a", "a");
  (void)folder.file("up/b", "b");
  for (const std::string part : {"new", "old"}) {
    fs::remove_all(folder / "src");
    fs::remove_all(folder / "up/repo");
    fs::create_directories(folder / "src/.drive-run.ardent");
    (void)folder.file("src/.drive-run.ardent/lock",
                      "Held by ardent while it writes the results beside this folder. Once no ardent runs the folder "
                      "may be removed.\n");
    fs::create_directory_symlink("../..", folder / ("src/.drive-run.ardent/" + part));
    fs::copy(bench() / "duffing/response.csv", folder / "src/drive.csv");
    REQUIRE(support::run(folder, "cp -a src up/repo").code == 0);  // as git, tar and zip bring it
    const auto before = contents(folder / "up");
    for (const char* force : {"", " --force"})
      expect(folder, std::string("cd up/repo && $ARDENT run drive.csv") + force, 5,
             {"[output.foreign] .drive-run.ardent: is not Ardent's", "Move it"});
    CHECK(contents(folder / "up") == before);
  }
}

TEST_CASE("no command follows a link that is planted where it writes", "[apps][planted_files]") {
  const Scratch& folder = bench();
  for (const Command& command : commands) {
    const std::string line = line_of(command);
    const fs::path place = folder / command.place;
    const bool is_folder = command.place == "out";
    const std::string stem = "." + place.filename().string() + ".ardent";
    const auto refused = [&](const char* what, const std::string& name) {
      CAPTURE(what, command.line);
      const auto before = contents(folder / "");
      for (const char* force : {"", " --force"}) expect(folder, line + force, 5, {"error [output." + name});
      CHECK(contents(folder / "") == before);
      fs::remove_all(folder / "out");
    };
    const auto make_around = [&] { fs::create_directories(place.parent_path()); };
    for (const char* part : {"new", "old", "lock"})
      for (const std::string& name : {stem, stem + "-0123456789abcdef"}) {
        make_around();
        fs::create_directories(place.parent_path() / name);
        fs::create_directory_symlink(folder / "victim", place.parent_path() / name / part);
        refused("a link in the staging folder", "foreign] ");
        fs::remove_all(place.parent_path() / name);
      }
    make_around();
    fs::create_directory_symlink(folder / "victim", place.parent_path() / (stem + "-0123456789abcdef"));
    refused("a link as the staging folder", "foreign] ");
    fs::remove(place.parent_path() / (stem + "-0123456789abcdef"));
    for (const char* target : {"victim", "nothing", "out"}) {  // to a folder, to nowhere, to itself
      if (command.place != "out/summary" || target == std::string("victim")) make_around();
      fs::path link = place;
      if (command.place == "out/summary") fs::remove(link = folder / "out");
      fs::create_directory_symlink(folder / target, link);
      refused("a link as the destination", "");
    }
    if (is_folder) {
      REQUIRE(support::run(folder, line).code == 0);
      fs::create_directory_symlink(folder / "victim", place / "further");
      refused("a link in an earlier result, which --force replaces", "");
    }
    check_victim(folder);
  }
}

TEST_CASE("an earlier result is replaced where its own files are, not where links in their place lead",
          "[apps][planted_files]") {
  const Scratch& folder = bench();
  const std::string line = "$ARDENT -q run duffing/response.csv -o out";
  const auto with = [&](const std::string& what) {
    REQUIRE(support::run(folder, line).code == 0);
    REQUIRE(support::run(folder, what).code == 0);
    const auto before = contents(folder / "");
    expect(folder, line + " --force", 5, {"[output.foreign] out"});
    CHECK(contents(folder / "") == before);
    fs::remove_all(folder / "out");
  };
  with("rm -r out/figures; ln -s ../victim out/figures");
  with("mv out/figures kept; ln -s ../kept out/figures");  // with the very files that are listed
  fs::remove_all(folder / "kept");
  with("mv out/equation.txt kept; ln -s ../kept out/equation.txt");
  fs::remove(folder / "kept");
  with("mv out/manifest.json kept; ln -s ../kept out/manifest.json");
  fs::remove(folder / "kept");
  with("rm out/equation.txt; mkfifo out/equation.txt");
  // One file by two names is as good as another: the other name stays.
  REQUIRE(support::run(folder, line + " && ln out/equation.txt kept").code == 0);
  expect(folder, line + " --force", 0, {});
  CHECK_THAT(bytes_of(folder / "kept"), Catch::Contains("x^3"));
  fs::remove_all(folder / "out");
  fs::remove(folder / "kept");
  check_victim(folder);
}

TEST_CASE("a parent that is a link is what a person asked for", "[apps][planted_files]") {
  const Scratch& folder = bench();
  fs::create_directory(folder / "real");
  fs::create_directory_symlink("real", folder / "alias");
  expect(folder, "$ARDENT -q sim coulomb -o alias/out", 0, {});
  CHECK(fs::exists(folder / "real/out/manifest.json"));
  CHECK(std::distance(fs::directory_iterator(folder / "real"), {}) == 1);
  fs::remove_all(folder / "real");
  fs::remove(folder / "alias");
}

TEST_CASE("a batch writes into no link and over no file of a person's", "[apps][planted_files]") {
  const Scratch& folder = bench();
  const std::string line = "$ARDENT -q batch c.toml duffing/response.csv --jobs 1 -o out";
  fs::create_directory(folder / "out");
  fs::create_directory_symlink(folder / "victim", folder / "out/runs");
  expect(folder, line, 5, {"[output.symlink] out/runs"});
  fs::remove(folder / "out/runs");
  fs::create_directory(folder / "out/runs");
  for (const char* name : {"table.csv", "table.json", "report.html", "log.txt"}) {
    fs::create_symlink(folder / "victim/b", folder / "out" / name);
    expect(folder, line, 5, {std::string("[output.symlink] out/") + name});
    fs::remove(folder / "out" / name);
    (void)folder.file(std::string("out/") + name, "mine");
    expect(folder, line, 5, {std::string("[output.exists] out/") + name});
    CHECK(bytes_of(folder / "out" / name) == "mine");
    fs::remove(folder / "out" / name);
  }
  expect(folder, line, 0, {});
  fs::remove(folder / "out/table.csv");
  fs::create_symlink(folder / "victim/b", folder / "out/table.csv");
  expect(folder, line, 5, {"[output.foreign] out/table.csv"});
  fs::remove_all(folder / "out");
  check_victim(folder);
}

TEST_CASE("what is mounted in the way is not entered", "[apps][planted_files]") {
  const Scratch& folder = bench();
  if (support::run(folder, "unshare -m mount --bind victim victim").code != 0) {
    WARN("skipped: no right to mount");
    return;
  }
  const std::string line = "$ARDENT -q run duffing/response.csv -o out";
  // At the destination, in an earlier result in place of its folder, and in what a killed command left.
  expect(folder, "mkdir -p out && unshare -m sh -c 'mount --bind victim out && " + line + " --force'", 5,
         {"[output.foreign] out"});
  fs::remove(folder / "out");
  expect(folder, line + " && unshare -m sh -c 'mount --bind victim out/figures && " + line + " --force'", 5,
         {"[output.foreign] out/figures"});
  fs::remove_all(folder / "out");
  (void)support::run(folder, "ARDENT_AT=fsync:1 ARDENT_DO='kill -9 $PPID' LD_PRELOAD=" ARDENT_FAILING_CALLS " " + line);
  const std::string left = support::staging_of(folder / "out").filename().string();
  REQUIRE(left.starts_with(".out.ardent-"));
  for (const std::string part : {"/new", "/new/out/figures"})
    expect(folder, "unshare -m sh -c 'mount --bind victim " + left + part + " && " + line + "'", 5,
           {"[output.foreign] " + left + part});
  check_victim(folder);
  expect(folder, line, 0, {});
  CHECK_FALSE(fs::exists(folder / left));
  fs::remove_all(folder / "out");
}

#ifndef ARDENT_SANITIZED  // the sanitizers replace the same calls

// Between two calls of a command, at every place, somebody puts links or files of his own in its way.
TEST_CASE("what a folder becomes while a command runs is neither followed nor lost", "[apps][planted_files]") {
  const Scratch& folder = bench();
  const std::string line = "LD_PRELOAD=" ARDENT_FAILING_CALLS " $ARDENT -q sim duffing --duration 0.2 --force -o out";
  const std::array<std::string, 5> kinds{"write", "open", "rename", "unlink", "fsync"};
  std::map<std::string, long> counts;
  REQUIRE(support::run(folder, line).code == 0);
  REQUIRE(support::run(folder, "ARDENT_COUNTS=counts " + line).code == 0);
  std::istringstream text(bytes_of(folder / "counts"));
  for (const std::string& kind : kinds) text >> counts[kind];
  fs::remove(folder / "counts");
  const std::vector<std::string> deeds{"mv out gone; ln -s victim out",
                                       "mv out gone; mkdir out; echo mine > out/b",
                                       "echo mine > out/b",
                                       "echo mine > out/response.csv",
                                       "rm -r out; cp -r victim out",
                                       "s=$(echo .out.ardent-*); mv $s gone; ln -s victim $s",
                                       "s=$(echo .out.ardent-*); mv $s/new gone; ln -s ../victim $s/new",
                                       "s=$(echo .out.ardent-*); mv $s/new/out gone; ln -s ../../victim $s/new/out",
                                       "s=$(echo .out.ardent-*); ln -s ../../../victim $s/new/out/docs",
                                       "s=$(echo .out.ardent-*); ln -s ../victim $s/old",
                                       "s=$(echo .out.ardent-*); echo mine > $s/new/out/b"};
  long num_mine = 0;
  for (const std::string& deed : deeds)
    for (const std::string& kind : kinds)
      for (long number = 1; number <= counts[kind]; number += std::max(1L, counts[kind] / 12)) {
        CAPTURE(deed, kind, number);
        const auto ended = support::run(
            folder, fmt::format("ARDENT_AT={}:{} ARDENT_DO='{} && touch done' {}", kind, number, deed, line));
        CAPTURE(ended.err);
        CHECK((ended.code == 0 || ended.code == 3 || ended.code == 5));
        check_victim(folder);
        CHECK(std::distance(fs::recursive_directory_iterator(folder / "victim"), {}) == 3);
        // A person's file lies where it was put or in a folder that was moved with it.
        const bool brings = fs::exists(folder / "done") && deed.find("mine > ") != std::string::npos;
        long kept = 0;
        for (const auto& entry : fs::recursive_directory_iterator(folder / ""))
          if (entry.is_regular_file() && entry.path().filename() != "done" &&
              entry.path().string().find("/victim/") == std::string::npos && bytes_of(entry.path()) == "mine\n")
            ++kept;
        if (brings) {
          ++num_mine;
          CHECK(kept == 1);
        }
        REQUIRE(support::run(folder, "rm -rf out gone done .out.ardent*").code == 0);
        REQUIRE(support::run(folder, line).code == 0);
      }
  CHECK(num_mine > 20);
  fs::remove_all(folder / "out");
}

#endif

}  // namespace test_planted_files
