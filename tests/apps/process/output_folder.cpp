#include "apps/process/output_folder.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <optional>
#include <set>

#include "support/fault.hpp"
#include "support/scratch.hpp"

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

/// What a killed command leaves beside `NAME`, with the lock of a real one.
void leave_staging(const support::Scratch& folder, const std::string& name) {
  const fs::path staging = folder / ("." + name + ".ardent");
  {
    const apps::OutputFolder made(folder / name, true);
    fs::copy(staging, folder / "kept", fs::copy_options::recursive);
  }
  fs::rename(folder / "kept", staging);
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
  leave_staging(folder, "run");
  fs::create_directories(folder / ".run.ardent/new/run/figures");
  (void)folder.file(".run.ardent/new/run/equation.txt", "ha");
  SECTION("half of the new results") {}
  SECTION("also old ones that were moved aside, the new ones being in place") {
    fs::create_directories(folder / ".run.ardent/old");
    make_results(folder / "run", true, "old");
    leave_staging(folder, "run");
    fs::create_directory(folder / ".run.ardent/old");
    fs::copy(folder / "run", folder / ".run.ardent/old/run", fs::copy_options::recursive);
  }
  SECTION("no more than an empty lock") {
    fs::remove_all(folder / ".run.ardent/new");
    (void)folder.file(".run.ardent/lock", "");
  }
  SECTION("no more than the folder") {
    fs::remove_all(folder / ".run.ardent/new");
    fs::remove(folder / ".run.ardent/lock");
  }
  make_results(folder / "run", fs::exists(folder / "run"), "new");
  CHECK(bytes_of(folder / "run/equation.txt") == "new");
  CHECK(num_entries(folder / "") == 1);
}

TEST_CASE("old results that a killed command had moved aside come back", "[apps][output_folder]") {
  const support::Scratch folder;
  make_results(folder / "run", false, "old");
  leave_staging(folder, "run");
  fs::create_directory(folder / ".run.ardent/old");
  fs::rename(folder / "run", folder / ".run.ardent/old/run");
  check_fault([&] { make_results(folder / "run", false, "new"); }, output, "output.exists", {});
  CHECK(bytes_of(folder / "run/equation.txt") == "old");
  CHECK(num_entries(folder / "") == 1);
}

TEST_CASE("a hidden folder of that name that is not Ardent's is refused and stays", "[apps][output_folder]") {
  const support::Scratch folder;
  fs::path named = ".run.ardent";
  SECTION("without a lock") {
    fs::create_directories(folder / ".run.ardent/new");
    (void)folder.file(".run.ardent/new/diary", "mine");
  }
  SECTION("with a lock of another program") {
    fs::create_directories(folder / ".run.ardent");
    (void)folder.file(".run.ardent/lock", "4711");
    named /= "lock";
  }
  SECTION("a file") {
    (void)folder.file(".run.ardent", "mine");
  }
  SECTION("a link to a folder") {
    fs::create_directory(folder / "victim");
    fs::create_directory_symlink(folder / "victim", folder / ".run.ardent");
  }
  const auto contents = [&] {
    std::vector<std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder / "")) all.push_back(entry.path().string());
    return std::set<std::string>(all.begin(), all.end());
  };
  const auto before = contents();
  check_fault([&] { make_results(folder / "run", true, "a"); }, output, "output.foreign",
              {named.string() + ": is not Ardent's"});
  CHECK(contents() == before);
}

TEST_CASE("a person's file in results that were just replaced is kept and named by the next command",
          "[apps][output_folder]") {
  const support::Scratch folder;
  make_results(folder / "run", false, "new");
  leave_staging(folder, "run");
  fs::create_directories(folder / ".run.ardent/new");
  fs::copy(folder / "run", folder / ".run.ardent/new/run", fs::copy_options::recursive);
  (void)folder.file(".run.ardent/new/run/notes.txt", "mine");
  check_fault([&] { make_results(folder / "run", true, "newer"); }, output, "output.foreign",
              {".run.ardent/new/run/notes.txt: is not Ardent's and lies in .run.ardent, which a killed command left",
               "Move it elsewhere"});
  CHECK(bytes_of(folder / ".run.ardent/new/run/notes.txt") == "mine");
  CHECK(bytes_of(folder / ".run.ardent/new/run/equation.txt") == "new");
  CHECK(bytes_of(folder / "run/equation.txt") == "new");
}

TEST_CASE("a person's file beside the lock of a killed command is kept, and the message says where it is",
          "[apps][output_folder]") {
  const support::Scratch folder;
  leave_staging(folder, "run");
  (void)folder.file(".run.ardent/diary", "mine");
  check_fault([&] { make_results(folder / "run", true, "a"); }, output, "output.foreign",
              {".run.ardent/diary: is not Ardent's and lies in .run.ardent, which a killed command left behind",
               "Move it elsewhere, then try again"});
  CHECK(bytes_of(folder / ".run.ardent/diary") == "mine");
  fs::rename(folder / ".run.ardent/diary", folder / "diary");
  make_results(folder / "run", true, "a");
  CHECK_FALSE(fs::exists(folder / ".run.ardent"));
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
