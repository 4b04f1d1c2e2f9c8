#include "apps/output/output_folder.hpp"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <map>
#include <optional>

#include "support/fault.hpp"
#include "support/scratch.hpp"
#include "support/staging.hpp"

namespace test_process_output_folder {

using support::bytes_of;
using support::check_fault;
using support::fault_of;
using support::name_of_fault;
namespace fs = std::filesystem;

namespace {
constexpr auto output = dsp::FaultKind::output;

apps::Manifest manifest() {
  apps::Manifest made;
  made.command = "test";
  return made;
}

void make_results(const fs::path& path, bool force, std::string_view text) {
  apps::OutputFolder folder(path, force);
  folder.write("equation.txt", text);
  folder.write("figures/fit.svg", "<svg/>");
  folder.commit(manifest());
}

long num_entries(const fs::path& path) {
  return std::distance(fs::directory_iterator(path), {});
}

/// What a command that is killed leaves beside `NAME`: its staging folder.
fs::path leave_staging(const support::Scratch& folder, const std::string& name) {
  const pid_t child = ::fork();
  if (child == 0) {
    const apps::OutputFolder killed(folder / name, true);
    ::_exit(0);
  }
  ::waitpid(child, nullptr, 0);
  fs::path staging = support::staging_of(folder / name);
  REQUIRE(fs::exists(staging / "lock"));
  return staging;
}

/// Every path in a folder with what is there.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    all[entry.path().string()] = entry.is_symlink()        ? fs::read_symlink(entry.path()).string()
                                 : entry.is_regular_file() ? bytes_of(entry.path())
                                                           : "";
  return all;
}
}  // namespace

TEST_CASE("a folder of results appears whole, with nothing left beside it", "[apps][output_folder]") {
  const support::Scratch folder;
  {
    apps::OutputFolder results(folder / "new/run/", false);
    results.write("equation.txt", "a = x");
    CHECK_FALSE(fs::exists(folder / "new/run"));
    results.commit(manifest());
  }
  CHECK(bytes_of(folder / "new/run/equation.txt") == "a = x");
  const auto listed = apps::listed_outputs(folder / "new/run");
  REQUIRE(listed);
  REQUIRE(listed->size() == 1);
  CHECK(listed->front().path == "equation.txt");
  CHECK(num_entries(folder / "new") == 1);
}

TEST_CASE("results that are not finished leave nothing, nor the folders made for them", "[apps][output_folder]") {
  const support::Scratch folder;
  { apps::OutputFolder(folder / "a/b/run", false).write("equation.txt", "a"); }
  CHECK(num_entries(folder / "") == 0);
}

TEST_CASE("an empty folder that is there already is filled", "[apps][output_folder]") {
  const support::Scratch folder;
  fs::create_directory(folder / "run");
  make_results(folder / "run", false, "a");
  CHECK(bytes_of(folder / "run/equation.txt") == "a");
}

TEST_CASE("earlier results are replaced only by force, and then whole", "[apps][output_folder]") {
  const support::Scratch folder;
  make_results(folder / "run", false, "old");
  check_fault([&] { make_results(folder / "run", false, "new"); }, output, "output.exists", {"--force"});
  CHECK(bytes_of(folder / "run/equation.txt") == "old");
  {
    apps::OutputFolder results(folder / "run", true);
    results.write("equation.txt", "new");
    CHECK(bytes_of(folder / "run/equation.txt") == "old");
    results.commit(manifest());
  }
  CHECK(bytes_of(folder / "run/equation.txt") == "new");
  CHECK_FALSE(fs::exists(folder / "run/figures"));
  CHECK(num_entries(folder / "") == 1);
}

TEST_CASE("a person's file, folder or change in earlier results stops their replacement and is named",
          "[apps][output_folder]") {
  const support::Scratch folder;
  make_results(folder / "run", false, "old");
  std::string first = "notes.txt";
  SECTION("a further file") {
    (void)folder.file("run/notes.txt", "mine");
  }
  SECTION("a further folder with files in it") {
    fs::create_directories(folder / "run/notes.txt/deep");
    (void)folder.file("run/notes.txt/deep/b", "mine");
  }
  SECTION("a link") {
    fs::create_symlink(folder / "run/equation.txt", folder / "run/notes.txt");
  }
  SECTION("a listed file that was edited") {
    (void)folder.file("run/equation.txt", "mine");
    first = "equation.txt";
  }
  SECTION("beside a listed file, deep down") {
    first = "figures/mine.svg";
    (void)folder.file("run/figures/mine.svg", "mine");
  }
  check_fault([&] { make_results(folder / "run", true, "new"); }, output, "output.foreign",
              {"run/" + first, "Move it"});
  (void)folder.file("run/other.txt", "mine, too");
  check_fault([&] { make_results(folder / "run", true, "new"); }, output, "output.foreign", {"and 1 more"});
  CHECK(fs::exists(fs::symlink_status(folder / ("run/" + first))));
  CHECK(bytes_of(folder / "run/other.txt") == "mine, too");
  CHECK(num_entries(folder / "") == 1);
}

TEST_CASE("a file that comes into earlier results while new ones are made is kept", "[apps][output_folder]") {
  const support::Scratch folder;
  make_results(folder / "run", false, "old");
  {
    apps::OutputFolder results(folder / "run", true);
    (void)folder.file("run/notes.txt", "mine");
    check_fault([&] { results.commit(manifest()); }, output, "output.foreign", {"run/notes.txt"});
  }
  CHECK(bytes_of(folder / "run/notes.txt") == "mine");
  CHECK(bytes_of(folder / "run/equation.txt") == "old");
}

TEST_CASE("earlier results from which something was taken are still replaced", "[apps][output_folder]") {
  const support::Scratch folder;
  make_results(folder / "run", false, "old");
  fs::remove_all(folder / "run/figures");
  make_results(folder / "run", true, "new");
  CHECK(bytes_of(folder / "run/equation.txt") == "new");
}

TEST_CASE("a folder that is not ours is never replaced", "[apps][output_folder]") {
  const support::Scratch folder;
  fs::create_directory(folder / "thesis");
  (void)folder.file("thesis/chapter1.tex", "years of work");
  const auto refused = [&](const char* name) {
    return name_of_fault([&] { make_results(folder / name, true, "a"); }) == "output.foreign";
  };
  CHECK(refused("thesis"));
  for (const char* text :
       {R"({"program": "another", "outputs": []})", R"({"name": "x", "uses": ["ardent"], "program": "npm"})",
        R"({"program": "ardent"})", R"({"program": "ardent", "outputs": [{"path": "../chapter1.tex"}]})", R"("ardent")",
        "{\"program\": \"ardent\", "}) {
    CAPTURE(text);
    (void)folder.file("thesis/manifest.json", text);
    CHECK(refused("thesis"));
  }
  (void)folder.file("file", "text");
  CHECK(refused("file"));
  CHECK(bytes_of(folder / "thesis/chapter1.tex") == "years of work");
}

TEST_CASE("files of a person beside the results are not touched", "[apps][output_folder]") {
  const support::Scratch folder;
  const std::vector<std::string> names{"run.lock", "run.partial", "run.old", "run.tmp"};
  for (const std::string& name : names) (void)folder.file(name, "mine");
  make_results(folder / "run", false, "old");
  make_results(folder / "run", true, "new");
  (void)folder.file("run/notes.txt", "mine");
  (void)fault_of([&] { make_results(folder / "run", true, "newer"); });
  for (const std::string& name : names) CHECK(bytes_of(folder / name) == "mine");
}

TEST_CASE("what a killed command left is cleared by the next one, without force", "[apps][output_folder]") {
  const support::Scratch folder;
  bool has_results = false;
  SECTION("half of the new results") {
    const fs::path staging = leave_staging(folder, "run");
    fs::create_directories(staging / "new/run/figures");
    std::ofstream(staging / "new/run/equation.txt") << "ha";
  }
  SECTION("also old ones that were moved aside, the new ones being in place") {
    make_results(folder / "run", true, "old");
    const fs::path staging = leave_staging(folder, "run");
    fs::create_directory(staging / "old");
    fs::copy(folder / "run", staging / "old/run", fs::copy_options::recursive);
    has_results = true;
  }
  SECTION("of two commands") {
    const fs::path staging = leave_staging(folder, "run");
    fs::rename(staging, folder / "kept");
    (void)leave_staging(folder, "run");
    fs::rename(folder / "kept", staging);
  }
  SECTION("no more than an empty lock") {
    const fs::path staging = leave_staging(folder, "run");
    for (const char* part : {"new", "old"}) fs::remove_all(staging / part);
  }
  SECTION("no more than the folder") {
    const fs::path staging = leave_staging(folder, "run");
    for (const char* part : {"new", "old", "lock"}) fs::remove_all(staging / part);
  }
  SECTION("no more than a folder that had not got its name yet") {
    fs::create_directory(folder / ".run.ardent-0123abcd");
  }
  make_results(folder / "run", has_results, "new");
  CHECK(bytes_of(folder / "run/equation.txt") == "new");
  CHECK(num_entries(folder / "") == 1);
}

TEST_CASE("old results that a killed command had moved aside come back", "[apps][output_folder]") {
  const support::Scratch folder;
  make_results(folder / "run", false, "old");
  const fs::path staging = leave_staging(folder, "run");
  fs::create_directory(staging / "old");
  fs::rename(folder / "run", staging / "old/run");
  check_fault([&] { make_results(folder / "run", false, "new"); }, output, "output.exists", {});
  CHECK(bytes_of(folder / "run/equation.txt") == "old");
  CHECK(num_entries(folder / "") == 1);
}

TEST_CASE("a hidden folder that is called like Ardent's and was not made here is refused and stays",
          "[apps][output_folder]") {
  const support::Scratch folder;
  fs::create_directories(folder / "victim/docs");
  (void)folder.file("victim/docs/a", "years of work");
  const fs::path look_alike = folder / ".run.ardent-0123456789abcdef", earlier = folder / ".run.ardent";
  const auto make_look_alike = [](const fs::path& place) {
    fs::create_directories(place / "new");
    std::ofstream(place / "lock") << "Held by ardent while it writes the results beside this folder. Once no ardent "
                                     "runs the folder may be removed.\n";
  };
  fs::path named = look_alike;
  SECTION("without a lock") {
    fs::create_directories(look_alike / "new");
    (void)folder.file(".run.ardent-0123456789abcdef/new/diary", "mine");
  }
  SECTION("with lock and files") {
    make_look_alike(look_alike);
    (void)folder.file(".run.ardent-0123456789abcdef/new/diary", "mine");
  }
  SECTION("with links to folders") {
    make_look_alike(look_alike);
    fs::remove(look_alike / "new");
    for (const char* part : {"new", "old"}) fs::create_directory_symlink("../victim", look_alike / part);
  }
  SECTION("as earlier versions called it, with the text of their lock and links to folders") {
    make_look_alike(named = earlier);
    fs::remove(earlier / "new");
    for (const char* part : {"new", "old"}) fs::create_directory_symlink("../victim", earlier / part);
  }
  SECTION("as earlier versions called it, empty") {
    fs::create_directory(named = earlier);
  }
  SECTION("with links that lead nowhere or to themselves") {
    make_look_alike(look_alike);
    fs::create_symlink("nothing", look_alike / "old");
    fs::create_symlink("loop", look_alike / "new/loop");
  }
  SECTION("with another file's hard link as its lock") {
    fs::create_directories(look_alike / "new");
    fs::create_hard_link(folder / "victim/docs/a", look_alike / "lock");
  }
  SECTION("a file") {
    (void)folder.file(".run.ardent-0123456789abcdef", "mine");
  }
  SECTION("a link to a folder") {
    fs::create_directory_symlink("victim", look_alike);
  }
  SECTION("a link that leads nowhere") {
    fs::create_directory_symlink("nothing", look_alike);
  }
  SECTION("a pipe as its lock") {
    fs::create_directories(look_alike / "new");
    REQUIRE(::mkfifo((look_alike / "lock").c_str(), 0600) == 0);
  }
  SECTION("a copy of what a killed command left elsewhere") {
    fs::create_directory(folder / "elsewhere");
    const support::Scratch other;
    const fs::path left = leave_staging(other, "run");
    std::ofstream(left / "new/run/diary") << "mine";
    named = folder / left.filename().string();
    fs::copy(left, named, fs::copy_options::recursive);
  }
  const auto before = contents(folder / "");
  for (const bool force : {false, true})
    check_fault([&] { make_results(folder / "run", force, "a"); }, output, "output.foreign",
                {named.filename().string() + ": is not Ardent's", "Move it"});
  CHECK(contents(folder / "") == before);
}

TEST_CASE("hidden folders of other names are nobody's business", "[apps][output_folder]") {
  const support::Scratch folder;
  for (const char* name : {".run.ardently", ".walk.ardent-0123456789abcdef", ".run", "run.ardent"}) {
    fs::create_directory(folder / name);
    (void)folder.file(std::string(name) + "/diary", "mine");
  }
  const auto before = contents(folder / "");
  make_results(folder / "run", false, "a");
  fs::remove_all(folder / "run");
  CHECK(contents(folder / "") == before);
}

TEST_CASE("what a person puts into the left folder of a killed command is kept, and the message says where it is",
          "[apps][output_folder]") {
  const support::Scratch folder;
  make_results(folder / "run", false, "new");
  fs::create_directory(folder / "victim");
  (void)folder.file("victim/a", "years of work");
  const fs::path staging = leave_staging(folder, "run");
  fs::path named = staging / "new/run/notes.txt";
  const auto mine = [&](const fs::path& file) { std::ofstream(file) << "mine"; };
  SECTION("beside its lock") {
    mine(named = staging / "diary");
  }
  SECTION("in results that were just replaced") {
    fs::copy(folder / "run", staging / "new/run", fs::copy_options::recursive);
    mine(named);
  }
  SECTION("in place of a file of theirs") {
    fs::copy(folder / "run", staging / "new/run", fs::copy_options::recursive);
    mine(named = staging / "new/run/equation.txt");
  }
  SECTION("a link among them") {
    fs::copy(folder / "run", staging / "new/run", fs::copy_options::recursive);
    fs::create_directory_symlink(folder / "victim", named);
  }
  SECTION("a link among half of them") {
    fs::create_directory_symlink(folder / "victim", named);
  }
  SECTION("a link in place of them") {
    fs::remove_all(staging / "new/run");
    fs::create_directory_symlink(folder / "victim", named = staging / "new/run");
  }
  SECTION("a link in place of all of them") {
    fs::remove_all(staging / "new");
    fs::create_directory_symlink(folder / "victim", named = staging / "new");
  }
  SECTION("in what is left of old ones") {
    fs::create_directory(staging / "old/run");
    mine(named = staging / "old/run/notes.txt");
  }
  SECTION("a link in place of old ones") {
    fs::remove(staging / "old");
    fs::create_directory_symlink(folder / "victim", named = staging / "old");
  }
  const auto before = contents(folder / "");
  check_fault([&] { make_results(folder / "run", true, "newer"); }, output, "output.foreign",
              {named.lexically_relative(folder / "").string() + ": is not Ardent's", "Move it elsewhere"});
  CHECK(contents(folder / "") == before);
  fs::rename(named, folder / "moved");
  make_results(folder / "run", true, "newer");
  CHECK(bytes_of(folder / "run/equation.txt") == "newer");
  CHECK_FALSE(fs::exists(staging));
  CHECK(bytes_of(folder / "victim/a") == "years of work");
}

TEST_CASE("a symbolic link at the output place is refused", "[apps][output_folder]") {
  const support::Scratch folder;
  fs::create_directory(folder / "victim");
  fs::create_directory_symlink(folder / "victim", folder / "run");
  CHECK(name_of_fault([&] { make_results(folder / "run", true, "a"); }) == "output.symlink");
  CHECK(fs::is_empty(folder / "victim"));
}

TEST_CASE("two commands cannot write one folder", "[apps][output_folder]") {
  const support::Scratch folder;
  std::optional<apps::OutputFolder> first(std::in_place, folder / "run", false);
  for (const bool force : {false, true})
    check_fault([&] { apps::OutputFolder(folder / "run", force); }, output, "output.locked", {"run: another"});
  first.reset();
  make_results(folder / "run", false, "a");
  CHECK(bytes_of(folder / "run/equation.txt") == "a");
}

TEST_CASE("the current folder and those around it are refused in words", "[apps][output_folder]") {
  const support::Scratch folder;
  fs::create_directories(folder / "here/below");
  const fs::path before = fs::current_path();
  fs::current_path(folder / "here/below");
  for (const char* name : {".", "./", "..", "../../here", "../below/.", "/"}) {
    CAPTURE(name);
    check_fault([&] { make_results(name, true, "a"); }, dsp::FaultKind::usage, "output.current",
                {std::string(name) + ": is the current folder or holds it", "-o results"});
  }
  make_results("results", false, "a");
  fs::current_path(before);
  CHECK(bytes_of(folder / "here/below/results/equation.txt") == "a");
}

TEST_CASE("an output that would touch an input is refused", "[apps][output_folder]") {
  const support::Scratch folder;
  fs::create_directory(folder / "data");
  fs::create_directory_symlink(folder / "data", folder / "alias");
  const std::vector<fs::path> inputs{folder.file("data/a.csv", "x")};
  const auto refused = [&](const fs::path& place) {
    try {
      apps::require_apart(place, inputs);
      return false;
    } catch (const dsp::Fault& fault) {
      return fault.kind() == dsp::FaultKind::usage && fault.name() == "output.overlap";
    }
  };
  CHECK(refused(folder / "data/a.csv"));
  CHECK(refused(folder / "data/a.csv/run"));
  CHECK(refused(folder / "data"));
  CHECK(refused(folder / "data/"));
  CHECK(refused(folder / "alias"));
  CHECK(refused(folder / "data/../data"));
  CHECK(refused("/"));
  CHECK_FALSE(refused(folder / "data/run"));
  CHECK_FALSE(refused(folder / "data/a.csv.run"));
}

TEST_CASE("a file name that leaves the folder is the caller's mistake", "[apps][output_folder]") {
  const support::Scratch folder;
  const apps::OutputFolder results(folder / "run", false);
  for (const char* name : {"", "/etc/x", "../x", "figures/../../x", "."})
    CHECK_THROWS_AS(results.write(name, "a"), std::invalid_argument);
}

TEST_CASE("a manifest names what is near by its way and what is elsewhere by its name", "[apps][manifest]") {
  const support::Scratch folder;
  fs::create_directories(folder / "work/run");
  fs::create_directories(folder / "home/joe");
  const fs::path run = folder / "work/run";
  CHECK(apps::manifest_path(folder / "work/run/a.csv", run) == "a.csv");
  CHECK(apps::manifest_path(folder / "work/x.wav", run) == "../x.wav");
  CHECK(apps::manifest_path(folder / "work/data/x.wav", run) == "../data/x.wav");
  CHECK(apps::manifest_path(folder / "home/joe/x.wav", run) == "x.wav");
  CHECK(apps::manifest_path(run, run) == ".");
  const std::string joe = (folder / "home/joe/").string();
  const std::vector<std::string> typed{"run",
                                       joe + "x.wav",
                                       "-o" + run.string(),
                                       "--set",
                                       "segment.file=\"" + joe + "s.json\"",
                                       "--over=a=" + joe + "p,../../../" + "q",
                                       "terms=[\"x/v\", \"1/x\"]",
                                       "data/y.csv"};
  CHECK(apps::manifest_arguments(typed, run) == std::vector<std::string>{"run", "x.wav", "-o.", "--set",
                                                                         "segment.file=\"s.json\"", "--over=a=p,q",
                                                                         "terms=[\"x/v\", \"1/x\"]", "data/y.csv"});
}

}  // namespace test_process_output_folder
