#include "apps/process/sha256.hpp"

#include <catch2/catch.hpp>

#include "support/fault.hpp"
#include "support/scratch.hpp"

TEST_CASE("SHA-256 gives the digests of FIPS 180-4", "[apps][sha256]") {
  CHECK(apps::sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(apps::sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(apps::sha256(std::string(1'000'000, 'a')) ==
        "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("a file has the digest of its bytes, whatever the block", "[apps][sha256]") {
  const support::Scratch folder;
  const std::string bytes(1'000'000, 'a');
  (void)folder.file("a", bytes);
  CHECK(apps::sha256_file(folder / "a") == apps::sha256(bytes));
  CHECK(support::name_of_fault([&] { (void)apps::sha256_file(folder / "none"); }) == "file.missing");
  CHECK(support::name_of_fault([&] { (void)apps::sha256_file(folder / ""); }) == "file.kind");
}
