#include "apps/process/atomic_file.hpp"

#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <csignal>

#include "dsp/fault.hpp"
#include "support/fault.hpp"
#include "support/scratch.hpp"

using support::bytes_of;
using support::fault_of;

TEST_CASE("a file is absent until it is committed and whole after", "[apps][atomic_file]") {
  const support::Scratch folder;
  const std::string bytes(3'000'000, 'x');  // three times the buffer
  {
    apps::AtomicFile file(folder / "a");
    file.write(bytes);
    CHECK_FALSE(std::filesystem::exists(folder / "a"));
    file.commit();
  }
  CHECK(bytes_of(folder / "a") == bytes);
  CHECK(std::distance(std::filesystem::directory_iterator(folder / ""), {}) == 1);
}

TEST_CASE("a file that was not committed leaves the old one and nothing else", "[apps][atomic_file]") {
  const support::Scratch folder;
  apps::write_file(folder / "a", "old");
  { apps::AtomicFile(folder / "a").write("new"); }
  CHECK(bytes_of(folder / "a") == "old");
  CHECK(std::distance(std::filesystem::directory_iterator(folder / ""), {}) == 1);
}

TEST_CASE("a missing parent folder is told with the remedy", "[apps][atomic_file]") {
  const support::Scratch folder;
  const auto fault = fault_of([&] { apps::write_file(folder / "none/a", "text"); });
  CHECK(fault.kind() == dsp::FaultKind::output);
  CHECK(fault.name() == "output.write");
  CHECK_THAT(fault.what(),
             Catch::Contains("none/a: cannot write: No such file or directory. Make its parent folder first."));
}

TEST_CASE("a symbolic link at the place of a file is not followed", "[apps][atomic_file]") {
  const support::Scratch folder;
  (void)folder.file("victim", "precious");
  std::filesystem::create_symlink(folder / "victim", folder / "a");
  CHECK(fault_of([&] { apps::write_file(folder / "a", "text"); }).name() == "output.symlink");
  CHECK(bytes_of(folder / "victim") == "precious");
}

TEST_CASE("a link planted at the temporary name is neither followed nor removed", "[apps][atomic_file]") {
  const support::Scratch folder;
  (void)folder.file("victim", "precious");
  const std::string planted = "a.tmp-" + std::to_string(::getpid()) + "-0";
  std::filesystem::create_symlink(folder / "victim", folder / planted);
  apps::write_file(folder / "a", "text");
  CHECK(bytes_of(folder / "a") == "text");
  CHECK(bytes_of(folder / "victim") == "precious");
  CHECK(std::filesystem::is_symlink(folder / planted));
}

TEST_CASE("a file size limit is a fault and the old file stays", "[apps][atomic_file]") {
  const support::Scratch folder;
  apps::write_file(folder / "a", "old");
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{.rlim_cur = 100'000, .rlim_max = before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const auto fault = fault_of([&] { apps::write_file(folder / "a", std::string(2'000'000, 'x')); });
  setrlimit(RLIMIT_FSIZE, &before);
  CHECK(fault.name() == "output.write");
  CHECK_THAT(fault.what(), Catch::Contains("File too large") && Catch::Contains("ulimit"));
  CHECK(bytes_of(folder / "a") == "old");
  CHECK(std::distance(std::filesystem::directory_iterator(folder / ""), {}) == 1);
}
