// ./run with programs in place of the package manager and the builder that say what those say.
#include <catch2/catch.hpp>
#include <fstream>

#include "support/program.hpp"

namespace fs = std::filesystem;
using support::Scratch;

namespace {

void put_program(const Scratch& folder, const std::string& name, const std::string& body) {
  fs::create_directories(folder / "bin");
  std::ofstream(folder / ("bin/" + name)) << "#!/bin/sh\n" << body << "\n";
  fs::permissions(folder / ("bin/" + name), fs::perms::owner_all);
}

/// The script, one package missing of two and the headers of one that is installed, ten steps to build, three tests.
void put_sources(const Scratch& folder) {
  fs::copy_file(fs::path(ARDENT_SOURCES) / "run", folder / "run");
  std::ofstream(folder / "apt.txt") << "there\nmissing\n";
  std::ofstream(folder / "apt-test.txt") << "there\n";
  std::ofstream(folder / "apt-headers.txt") << "there\n";
  put_program(folder, "id", "echo 0");
  put_program(folder, "nproc", "echo 2");
  put_program(folder, "dpkg-query", "case \"$3\" in there) printf installed ;; *) exit 1 ;; esac");
  put_program(folder, "apt-get", R"(case "$*" in
  *--assume-no*)
    echo '0 upgraded, 1,203 newly installed, 0 to remove and 5 not upgraded.'
    echo 'Need to get 12.5 MB/30 MB of archives.'
    echo 'After this operation, 1,112 MB of additional disk space will be used.'
    exit 1 ;;
  download*) echo 'noise of packages'; [ ! -e "$HERE/offline" ] && : > "$2.deb" ;;
  *) echo 'noise of packages'; [ ! -e no-packages ] ;;
esac)");
  put_program(folder, "cmake", R"(case "$*" in
  --build*)
    for i in 1 2 3 4 5 6 7 8 9 10; do
      echo "[$i/10] Building CXX object $i.o"
      [ ! -e broken ] || [ $i -lt 7 ] || { echo 'FAILED: 7.o'; echo 'exit 0'; exit 3; }
    done ;;
  *) echo 'noise of cmake' ;;
esac)");
  put_program(folder, "ctest", R"(for i in 1 2 3; do
  echo "      Start  $i: apps:a test"
  [ ! -e failing ] || [ $i -lt 2 ] || { echo "$i/3 Test  #$i: apps:a test ...***Failed    0.10 sec"; continue; }
  echo "$i/3 Test  #$i: apps:a test ........   Passed    0.10 sec"
done
echo '100% tests passed, 0 tests failed out of 3'
[ ! -e failing ] || exit 8)");
}

support::Ended run_script(const Scratch& folder, const std::string& arguments) {
  return support::run(folder, "HERE=$PWD PATH=\"$PWD/bin:$PATH\" sh ./run " + arguments);
}

}  // namespace

TEST_CASE("./run says what it installs, how far the build is and what to type next, and no more",
          "[apps][run_script]") {
  const Scratch folder;
  put_sources(folder);
  const auto built = run_script(folder, "build");
  CHECK(built.code == 0);
  CHECK(built.err.empty());
  CHECK(
      built.out.starts_with("installing packages: missing\n"
                            "1203 packages with what they need: 12.5 MB/30 MB to download, 1112 MB on disk, "
                            "about 6 min\nbuilding: all of it takes about "));
  CHECK(
      built.out.ends_with("building: 10 %\nbuilding: 20 %\nbuilding: 30 %\nbuilding: 40 %\nbuilding: 50 %\n"
                          "building: 60 %\nbuilding: 70 %\nbuilding: 80 %\nbuilding: 90 %\nbuilding: 100 %\n"
                          "next: build/release/ardent run data/qzs_256.flac -o rig-run\n"));
  const auto installed = run_script(folder, "install prefix");
  CHECK(installed.out.ends_with("next: prefix/bin/ardent run data/qzs_256.flac -o rig-run\n"));
  const auto tested = run_script(folder, "test");
  CHECK(tested.code == 0);
  CHECK_THAT(tested.out, Catch::EndsWith("testing: 100 %\n100% tests passed, 0 tests failed out of 3\n"));
  CHECK_THAT(built.out + installed.out + tested.out, !Catch::Contains("noise") && !Catch::Contains("Start"));
}

TEST_CASE("./run fetches the headers of packages that are not installed, once", "[apps][run_script]") {
  const Scratch folder;
  put_sources(folder);
  std::ofstream(folder / "apt-headers.txt") << "there\nheaders-dev\n";
  fs::create_directories(folder / "package/usr/include/some");
  std::ofstream(folder / "package/usr/include/some/header.h") << "of a package\n";
  std::ofstream(folder / "package/usr/large") << "and the rest of it\n";
  put_program(folder, "dpkg-deb", "exec tar -c -C \"$HERE/package\" .");
  std::ofstream(folder / "offline").close();
  const auto refused = run_script(folder, "build");
  CHECK(refused.code == 1);
  CHECK_THAT(refused.err, Catch::EndsWith("./run: headers-dev cannot be fetched. With a connection, try again; "
                                          "without, install headers-dev\n"));
  CHECK_THAT(refused.out, !Catch::Contains("building"));
  fs::remove(folder / "offline");
  const auto built = run_script(folder, "build");
  CHECK(built.code == 0);
  CHECK_THAT(built.out, Catch::Contains("fetching headers: headers-dev\n") && !Catch::Contains("noise"));
  CHECK(fs::exists(folder / "build/headers/usr/include/some/header.h"));
  CHECK_FALSE(fs::exists(folder / "build/headers/usr/large"));
  CHECK_THAT(run_script(folder, "build").out, !Catch::Contains("fetching"));
}

TEST_CASE("./run shows what failed and ends with its exit code", "[apps][run_script]") {
  const Scratch folder;
  put_sources(folder);
  std::ofstream(folder / "broken") << "";
  const auto built = run_script(folder, "install prefix");
  CHECK(built.code == 3);
  CHECK_THAT(built.out, Catch::EndsWith("building: 70 %\nFAILED: 7.o\nexit 0\n"));
  fs::remove(folder / "broken");
  std::ofstream(folder / "failing") << "";
  const auto tested = run_script(folder, "test");
  CHECK(tested.code == 8);
  CHECK_THAT(tested.out, Catch::Contains("#3: apps:a test ...***Failed"));
  std::ofstream(folder / "no-packages") << "";
  const auto refused = run_script(folder, "build");
  CHECK(refused.code != 0);
  CHECK_THAT(refused.err, Catch::Contains("noise of packages"));
  CHECK_THAT(refused.out, !Catch::Contains("building"));
}
