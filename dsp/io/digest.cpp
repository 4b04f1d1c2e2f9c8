#include "dsp/io/digest.hpp"

#include <openssl/evp.h>

#include <array>
#include <new>

#include "dsp/io/loaded_library.hpp"

namespace dsp {
namespace {

/// What of OpenSSL is used here, and a library context of our own: OpenSSL follows a null pointer in its default one
/// where memory for that ended.
struct Crypto {
  decltype(&::EVP_DigestFinal_ex) finish;
  decltype(&::EVP_DigestInit_ex) begin;
  decltype(&::EVP_DigestUpdate) update;
  decltype(&::EVP_MD_CTX_free) free;
  decltype(&::EVP_MD_CTX_new) make;
  decltype(&::EVP_MD_fetch) fetch;
  decltype(&::OSSL_LIB_CTX_new) make_library;
};

Crypto load() {
  const LoadedLibrary library({.file = ARDENT_CRYPTO_SONAME,
                               .package = ARDENT_CRYPTO_PACKAGE,
                               .kind = FaultKind::numerics,
                               .fault = "system.no_library",
                               .use = "files are hashed with OpenSSL",
                               .instead = ""});
#define ARDENT_FUNCTION(name) library.function<decltype(&::name)>(#name)
  return {.finish = ARDENT_FUNCTION(EVP_DigestFinal_ex),
          .begin = ARDENT_FUNCTION(EVP_DigestInit_ex),
          .update = ARDENT_FUNCTION(EVP_DigestUpdate),
          .free = ARDENT_FUNCTION(EVP_MD_CTX_free),
          .make = ARDENT_FUNCTION(EVP_MD_CTX_new),
          .fetch = ARDENT_FUNCTION(EVP_MD_fetch),
          .make_library = ARDENT_FUNCTION(OSSL_LIB_CTX_new)};
#undef ARDENT_FUNCTION
}

const Crypto& crypto() {
  static const Crypto loaded = load();
  return loaded;
}

template <class T>
T* made(T* what) {
  if (what == nullptr) throw std::bad_alloc();
  return what;
}

/// Kept to the end of the program, as the library is.
const EVP_MD* method_called(Digest::Method method) {
  static OSSL_LIB_CTX* const library = made(crypto().make_library());
  const auto fetch = [](const char* name) { return made(crypto().fetch(library, name, nullptr)); };
  if (method == Digest::Method::md5) {
    static EVP_MD* const md5 = fetch("MD5");
    return md5;
  }
  static EVP_MD* const sha256 = fetch("SHA256");
  return sha256;
}

}  // namespace

struct Digest::State {
  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context{crypto().make(), crypto().free};
};

Digest::Digest(Method method) : state_(std::make_unique<State>()) {
  if (!state_->context || crypto().begin(state_->context.get(), method_called(method), nullptr) != 1)
    throw std::bad_alloc();
}
Digest::~Digest() = default;
Digest::Digest(Digest&&) noexcept = default;

void Digest::push(std::string_view bytes) {
  if (crypto().update(state_->context.get(), bytes.data(), bytes.size()) != 1) throw std::bad_alloc();
}

std::string Digest::finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned int size = 0;
  if (crypto().finish(state_->context.get(), bytes.data(), &size) != 1) throw std::bad_alloc();
  return {bytes.begin(), bytes.begin() + size};
}

}  // namespace dsp
