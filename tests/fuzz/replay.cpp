// HARNESS FOLDER: runs the seeds, which have to be accepted, and every case in the folder, which may be refused; each
// soon.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "fuzz/harness.hpp"
#include "support/scratch.hpp"

namespace {

// A small input takes milliseconds; sanitizers and a busy machine may make fifty times as much of them.
constexpr double longest_s = 5.0;

bool ends_well(const std::string& name, const std::string& input, void (*run)(const std::string&)) {
  fmt::print(stderr, "{}\n", name);  // said first: a case that crashes or hangs is the last one named
  const auto start = std::chrono::steady_clock::now();
  try {
    run(input);
  } catch (const std::exception& error) {
    fmt::print(stderr, "FAILED {}: {}\n", name, error.what());
    return false;
  }
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (took_s > longest_s) fmt::print(stderr, "FAILED {}: {:.1f} s, want at most {} s\n", name, took_s, longest_s);
  return took_s <= longest_s;
}

}  // namespace

int main(int argc, char** argv) {
  fuzz::write_seeds_if_asked(argc, argv);
  if (argc != 2) return 2;
  std::vector<std::filesystem::path> cases;
  if (std::filesystem::exists(argv[1]))
    for (const auto& entry : std::filesystem::directory_iterator(argv[1])) cases.push_back(entry.path());
  std::sort(cases.begin(), cases.end());
  const std::vector<std::string> seeds = fuzz::seeds();
  std::size_t failed = 0;
  for (std::size_t i = 0; i < seeds.size(); ++i)
    failed += ends_well(fmt::format("seed {}", i), seeds[i], fuzz::run) ? 0 : 1;
  for (const auto& file : cases) failed += ends_well(file.string(), support::bytes_of(file), fuzz::execute) ? 0 : 1;
  fmt::print(stderr, "{} seeds and {} cases, {} failed\n", seeds.size(), cases.size(), failed);
  return failed == 0 ? 0 : 1;
}
