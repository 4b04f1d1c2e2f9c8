#include "fuzz/harness.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <string_view>
#include <system_error>

#include "dsp/values/fault.hpp"

namespace fuzz {
namespace {
constexpr std::string_view between_parts = "\n%%\n";
}

void execute(const std::string& input) {
  try {
    run(input);
  } catch (const dsp::Fault&) {
  }
}

void write_seeds_if_asked(int argc, const char* const* argv) {
  if (argc != 3 || std::string_view(argv[1]) != "--write-seeds") return;
  const std::filesystem::path folder = std::filesystem::absolute(argv[2]);
  const std::vector<std::string> all = seeds();
  for (std::size_t i = 0; i < all.size(); ++i)
    std::ofstream(folder / fmt::format("seed-{:02}", i), std::ios::binary) << all[i];
  std::exit(0);
}

std::vector<std::string> parts(const std::string& input) {
  std::vector<std::string> result;
  std::size_t from = 0, to = 0;
  while ((to = input.find(between_parts, from)) != std::string::npos) {
    result.push_back(input.substr(from, to - from));
    from = to + between_parts.size();
  }
  result.push_back(input.substr(from));
  return result;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string result;
  for (const std::string& part : parts) result += (&part == &parts.front() ? "" : std::string(between_parts)) + part;
  return result;
}

MemoryFile::MemoryFile(const std::string& content) : descriptor_(::memfd_create("fuzz", MFD_CLOEXEC)) {
  if (descriptor_ < 0 || ::write(descriptor_, content.data(), content.size()) != static_cast<ssize_t>(content.size()))
    throw std::system_error(errno, std::generic_category(), "memfd");
}

MemoryFile::~MemoryFile() {
  ::close(descriptor_);
}

std::filesystem::path MemoryFile::path() const {
  return fmt::format("/proc/self/fd/{}", descriptor_);
}

}  // namespace fuzz
