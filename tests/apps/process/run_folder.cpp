#include "apps/process/run_folder.hpp"

#include <catch2/catch.hpp>
#include <optional>

#include "support/fault.hpp"
#include "support/scratch.hpp"

using support::bytes_of;
using support::fault_of;
namespace fs = std::filesystem;

namespace {
constexpr auto manifest = R"({"program": "ardent"})";

void make_run(const fs::path& path, bool force, std::string_view text) {
  apps::RunFolder run(path, force);
  run.write("equation.txt", text);
  run.write("figures/fit.svg", "<svg/>");
  run.commit(manifest);
}

long num_entries(const fs::path& path) {
  return std::distance(fs::directory_iterator(path), {});
}
}  // namespace

TEST_CASE("a run folder appears whole, with nothing left beside it", "[apps][run_folder]") {
  const support::Scratch folder;
  {
    apps::RunFolder run(folder / "new/run/", false);
    run.write("equation.txt", "a = x");
    CHECK_FALSE(fs::exists(folder / "new/run"));
    run.commit(manifest);
  }
  CHECK(bytes_of(folder / "new/run/equation.txt") == "a = x");
  CHECK(bytes_of(folder / "new/run/manifest.json") == manifest);
  CHECK(num_entries(folder / "new") == 1);
}

TEST_CASE("an unfinished run leaves nothing when it is unwound", "[apps][run_folder]") {
  const support::Scratch folder;
  { apps::RunFolder(folder / "run", false).write("equation.txt", "a"); }
  CHECK(num_entries(folder / "") == 0);
}

TEST_CASE("an empty folder that is there already is filled", "[apps][run_folder]") {
  const support::Scratch folder;
  fs::create_directory(folder / "run");
  make_run(folder / "run", false, "a");
  CHECK(bytes_of(folder / "run/equation.txt") == "a");
}

TEST_CASE("a complete run is replaced only by force, and then whole", "[apps][run_folder]") {
  const support::Scratch folder;
  make_run(folder / "run", false, "old");
  const auto fault = fault_of([&] { make_run(folder / "run", false, "new"); });
  CHECK(fault.kind() == dsp::FaultKind::output);
  CHECK(fault.name() == "output.exists");
  CHECK_THAT(fault.what(), Catch::Contains("--force"));
  CHECK(bytes_of(folder / "run/equation.txt") == "old");
  {
    apps::RunFolder run(folder / "run", true);
    run.write("equation.txt", "new");
    CHECK(bytes_of(folder / "run/equation.txt") == "old");
    run.commit(manifest);
  }
  CHECK(bytes_of(folder / "run/equation.txt") == "new");
  CHECK_FALSE(fs::exists(folder / "run/figures"));
  CHECK(num_entries(folder / "") == 1);
}

TEST_CASE("what a killed run left is called incomplete and redone by force", "[apps][run_folder]") {
  const support::Scratch folder;
  SECTION("in the folder of its own") {
    fs::create_directory(folder / "run.partial");
    (void)folder.file("run.partial/metrics.json", "{");
  }
  SECTION("in the run folder") {
    make_run(folder / "run", false, "old");
    fs::remove(folder / "run/manifest.json");
  }
  const auto fault = fault_of([&] { make_run(folder / "run", false, "new"); });
  CHECK(fault.name() == "output.incomplete");
  CHECK_THAT(fault.what(), Catch::Contains("incomplete") && Catch::Contains("--force"));
  make_run(folder / "run", true, "new");
  CHECK(bytes_of(folder / "run/equation.txt") == "new");
  CHECK(num_entries(folder / "") == 1);
}

TEST_CASE("a folder that is not ours is never removed", "[apps][run_folder]") {
  const support::Scratch folder;
  fs::create_directory(folder / "thesis");
  (void)folder.file("thesis/chapter1.tex", "years of work");
  CHECK(fault_of([&] { make_run(folder / "thesis", true, "a"); }).name() == "output.foreign");
  (void)folder.file("thesis/manifest.json", R"({"program": "another"})");
  CHECK(fault_of([&] { make_run(folder / "thesis", true, "a"); }).name() == "output.foreign");
  (void)folder.file("file", "text");
  CHECK(fault_of([&] { make_run(folder / "file", true, "a"); }).name() == "output.foreign");
  CHECK(bytes_of(folder / "thesis/chapter1.tex") == "years of work");
}

TEST_CASE("a symbolic link at the output place is refused", "[apps][run_folder]") {
  const support::Scratch folder;
  fs::create_directory(folder / "victim");
  fs::create_directory_symlink(folder / "victim", folder / "run");
  CHECK(fault_of([&] { make_run(folder / "run", true, "a"); }).name() == "output.symlink");
  (void)folder.file("target", "precious");
  fs::create_symlink(folder / "target", folder / "other.lock");
  CHECK(fault_of([&] { make_run(folder / "other", true, "a"); }).name() == "output.write");
  CHECK(bytes_of(folder / "target") == "precious");
  CHECK(fs::is_empty(folder / "victim"));
}

TEST_CASE("a link planted at the partial name is removed, not what it points to", "[apps][run_folder]") {
  const support::Scratch folder;
  fs::create_directory(folder / "victim");
  (void)folder.file("victim/data", "precious");
  fs::create_directory_symlink(folder / "victim", folder / "run.partial");
  make_run(folder / "run", true, "a");
  CHECK(bytes_of(folder / "victim/data") == "precious");
  CHECK(num_entries(folder / "victim") == 1);
}

TEST_CASE("two runs cannot write one folder", "[apps][run_folder]") {
  const support::Scratch folder;
  std::optional<apps::RunFolder> first(std::in_place, folder / "run", false);
  for (const bool force : {false, true}) {
    const auto fault = fault_of([&] { apps::RunFolder(folder / "run", force); });
    CHECK(fault.kind() == dsp::FaultKind::output);
    CHECK(fault.name() == "output.locked");
  }
  first.reset();
  make_run(folder / "run", false, "a");
  CHECK(bytes_of(folder / "run/equation.txt") == "a");
}

TEST_CASE("an output that would touch an input is refused", "[apps][run_folder]") {
  const support::Scratch folder;
  fs::create_directory(folder / "data");
  fs::create_directory_symlink(folder / "data", folder / "alias");
  const std::vector<fs::path> inputs{folder.file("data/a.csv", "x")};
  const auto refused = [&](const fs::path& output) {
    try {
      apps::require_apart(output, inputs);
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

TEST_CASE("a file name that leaves the run folder is the caller's mistake", "[apps][run_folder]") {
  const support::Scratch folder;
  apps::RunFolder run(folder / "run", false);
  for (const char* name : {"", "/etc/x", "../x", "figures/../../x", "."})
    CHECK_THROWS_AS(run.write(name, "a"), std::invalid_argument);
}
