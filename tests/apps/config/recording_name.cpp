#include "apps/config/recording_name.hpp"

#include <catch2/catch.hpp>

#include "support/scratch.hpp"

namespace fs = std::filesystem;
using Names = std::vector<std::string>;
using support::Scratch;

TEST_CASE("a recording is called by its file, and by its folders where two files have one name",
          "[apps][recording_name]") {
  CHECK(apps::recording_names({"a/drive.csv", "a/other.csv"}) == Names{"drive.csv", "other.csv"});
  CHECK(apps::recording_names({"mon/drive.csv", "tue/drive.csv"}) == Names{"mon/drive.csv", "tue/drive.csv"});
  CHECK(apps::recording_names({"x/mon/a.csv", "y/mon/a.csv", "a.txt"}) == Names{"x/mon/a.csv", "y/mon/a.csv", "a.txt"});
}

TEST_CASE("one file listed twice is numbered, and its folders stay out of its name", "[apps][recording_name]") {
  CHECK(apps::recording_names({"mon/a.csv", "mon/../mon/a.csv", "mon/b.csv"}) == Names{"a.csv", "a.csv (2)", "b.csv"});
  CHECK(apps::recording_names({"mon/a.csv", "mon/a.csv", "tue/a.csv"}) ==
        Names{"mon/a.csv", "mon/a.csv (2)", "tue/a.csv"});
}

TEST_CASE("the name is of the place, not of how it is typed; a link keeps its own name", "[apps][recording_name]") {
  const Scratch folder;
  for (const char* day : {"mon", "tue"}) {
    fs::create_directory(folder / day);
    (void)folder.file(std::string(day) + "/a.csv", "t,x\n");
  }
  fs::create_directory_symlink(folder / "tue", folder / "latest");
  fs::create_symlink(folder / "mon/a.csv", folder / "tue/link.csv");
  const Names wanted{"mon/a.csv", "tue/a.csv", "link.csv"};
  const fs::path typed = folder / "mon/..";
  CHECK(apps::recording_names({folder / "mon/a.csv", folder / "latest/a.csv", folder / "tue/link.csv"}) == wanted);
  CHECK(apps::recording_names({typed / "mon/a.csv", typed / "tue/a.csv", folder / "latest/link.csv"}) == wanted);
}

TEST_CASE("a recording that a config does not list is named beside those that it does", "[apps][recording_name]") {
  apps::Config config;
  config.recordings = {{.file = "mon/a.csv"}, {.file = "mon/b.csv"}};
  config.test_recordings = {{.file = "tue/b.csv"}};
  apps::name_recordings(config);
  CHECK(config.recordings[1].name == "mon/b.csv");
  CHECK(config.test_recordings[0].name == "tue/b.csv");
  CHECK(apps::name_beside("tue/../mon/b.csv", config) == "mon/b.csv");
  CHECK(apps::name_beside("wed/a.csv", config) == "wed/a.csv");
  CHECK(apps::name_beside("c.csv", config) == "c.csv");
  CHECK(apps::recordings_called("mon/a.csv", config.recordings) == std::vector<std::size_t>{0});
  CHECK(apps::recordings_called("mon/b", config.recordings) == std::vector<std::size_t>{1});
  CHECK(apps::recordings_called("on/b", config.recordings).empty());
}
