#include "apps/process/output_file.hpp"

#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <csignal>

#include "support/fault.hpp"
#include "support/scratch.hpp"

using support::bytes_of;
using support::fault_of;
using support::name_of_fault;

namespace {
apps::Folder opened(const support::Scratch& folder) {
  return {folder / "", "results"};
}
}  // namespace

TEST_CASE("a file holds what was written once it is closed", "[apps][output_file]") {
  const support::Scratch folder;
  const std::string bytes(3'000'000, 'x');  // three times the buffer
  apps::write_file(opened(folder), "a", "shown/a", bytes);
  CHECK(bytes_of(folder / "a") == bytes);
}

TEST_CASE("what cannot be written is called as a person knows it, with the remedy", "[apps][output_file]") {
  const support::Scratch folder;
  std::filesystem::create_directory(folder / "none");
  const apps::Folder none(folder / "none", "results");
  std::filesystem::remove(folder / "none");
  const auto fault = fault_of([&] { apps::write_file(none, "a", "results/a", "text"); });
  CHECK(fault.kind() == dsp::FaultKind::output);
  CHECK(fault.name() == "output.write");
  CHECK(std::string(fault.what()) ==
        "results/a: cannot write: No such file or directory. Choose another place with -o.");
}

TEST_CASE("neither a file nor a link at the place of a new file is written to", "[apps][output_file]") {
  const support::Scratch folder;
  (void)folder.file("victim", "precious");
  std::filesystem::create_symlink(folder / "victim", folder / "a");
  for (const char* name : {"a", "victim"})
    CHECK(name_of_fault([&] { apps::write_file(opened(folder), name, name, "text"); }) == "output.write");
  CHECK(bytes_of(folder / "victim") == "precious");
}

TEST_CASE("a file size limit is a fault", "[apps][output_file]") {
  const support::Scratch folder;
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{.rlim_cur = 100'000, .rlim_max = before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const auto fault = fault_of([&] { apps::write_file(opened(folder), "a", "a", std::string(2'000'000, 'x')); });
  setrlimit(RLIMIT_FSIZE, &before);
  CHECK(fault.name() == "output.write");
  CHECK_THAT(fault.what(), Catch::Contains("File too large") && Catch::Contains("ulimit"));
}
