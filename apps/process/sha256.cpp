#include "apps/process/sha256.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <vector>

#include "dsp/io/digest.hpp"
#include "dsp/io/input_file.hpp"

namespace apps {
namespace {

std::string hexadecimal(const std::string& bytes) {
  std::string text;
  for (const char byte : bytes) text += fmt::format("{:02x}", static_cast<unsigned char>(byte));
  return text;
}

}  // namespace

std::string sha256(std::string_view bytes) {
  dsp::Digest digest(dsp::Digest::Method::sha256);
  digest.push(bytes);
  return hexadecimal(digest.finish());
}

std::string sha256_file(const std::filesystem::path& path, const std::stop_token& stop) {
  const dsp::InputFile file(path);
  dsp::Digest digest(dsp::Digest::Method::sha256);
  std::vector<char> block(1 << 18);
  std::uint64_t done = 0;
  while (const std::size_t size = file.read(done, block.data(), block.size())) {
    if (stop.stop_requested()) return {};
    digest.push({block.data(), size});
    done += size;
  }
  return hexadecimal(digest.finish());
}

}  // namespace apps
