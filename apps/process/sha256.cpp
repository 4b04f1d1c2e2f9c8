#include "apps/process/sha256.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <memory>
#include <new>
#include <vector>

#include "dsp/io/input_file.hpp"

namespace apps {
namespace {

/// From a library context of our own: OpenSSL follows a null pointer in its default one where memory for that ended.
const EVP_MD* sha256_method() {
  static const std::unique_ptr<OSSL_LIB_CTX, decltype(&OSSL_LIB_CTX_free)> library(OSSL_LIB_CTX_new(),
                                                                                   &OSSL_LIB_CTX_free);
  static const std::unique_ptr<EVP_MD, decltype(&EVP_MD_free)> method(
      library ? EVP_MD_fetch(library.get(), "SHA256", nullptr) : nullptr, &EVP_MD_free);
  if (!method) throw std::bad_alloc();
  return method.get();
}

class Digest {
 public:
  Digest() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    if (!context_ || EVP_DigestInit_ex(context_.get(), sha256_method(), nullptr) != 1) throw std::bad_alloc();
  }
  void update(const void* bytes, std::size_t size) { EVP_DigestUpdate(context_.get(), bytes, size); }
  std::string hexadecimal() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
    unsigned int size = 0;
    EVP_DigestFinal_ex(context_.get(), bytes.data(), &size);
    std::string text;
    for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", bytes[i]);
    return text;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

std::string sha256(std::string_view bytes) {
  Digest digest;
  digest.update(bytes.data(), bytes.size());
  return digest.hexadecimal();
}

std::string sha256_file(const std::filesystem::path& path, const std::stop_token& stop) {
  const dsp::InputFile file(path);
  Digest digest;
  std::vector<char> block(1 << 18);
  std::uint64_t done = 0;
  while (const std::size_t size = file.read(done, block.data(), block.size())) {
    if (stop.stop_requested()) return {};
    digest.update(block.data(), size);
    done += size;
  }
  return digest.hexadecimal();
}

}  // namespace apps
