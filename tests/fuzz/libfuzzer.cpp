#include <cstddef>
#include <cstdint>
#include <string>

#include "fuzz/harness.hpp"

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  fuzz::write_seeds_if_asked(*argc, *argv);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::execute(std::string(data, data + size));
  return 0;
}
