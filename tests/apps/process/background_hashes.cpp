#include "apps/process/background_hashes.hpp"

#include <catch2/catch.hpp>
#include <filesystem>

#include "apps/process/sha256.hpp"
#include "support/fault.hpp"
#include "support/scratch.hpp"

TEST_CASE("hashes made beside the reading are those of the files, on any number of threads", "[apps][sha256]") {
  const support::Scratch folder;
  std::vector<std::filesystem::path> files;
  for (int i = 0; i < 3; ++i)
    files.push_back(folder.file("file" + std::to_string(i), std::string(700'000 * i + 5, static_cast<char>('a' + i))));
  const auto missing = folder / "missing", other = folder.file("other", "o");
  for (const int num_threads : {1, 2}) {
    auto all = files;
    all.insert(all.begin() + 1, missing);
    all.push_back(files[0]);  // named twice
    apps::HashesBeside hashes(all, num_threads);
    for (const auto& file : {files[2], files[0], files[1], files[0], other})
      CHECK(hashes.of(file) == apps::sha256_file(file));
    CHECK(support::name_of_fault([&] { (void)hashes.of(missing); }) == "file.missing");
  }
}

TEST_CASE("hashing beside the reading stops when its result is no longer wanted", "[apps][sha256]") {
  const support::Scratch folder;
  const auto file = folder.file("hole", "");
  std::filesystem::resize_file(file, std::uintmax_t{1} << 40);  // ten minutes of hashing
  const apps::HashesBeside hashes({file, file}, 2);
}
