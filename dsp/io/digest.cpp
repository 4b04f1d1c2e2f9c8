#include "dsp/io/digest.hpp"

#include <nettle/md5.h>
#include <nettle/sha2.h>

#include <cstdint>
#include <variant>

namespace dsp {

struct Digest::State {
  std::variant<md5_ctx, sha256_ctx> of;
};

Digest::Digest(Method method) : state_(std::make_unique<State>()) {
  if (method == Method::md5)
    nettle_md5_init(&state_->of.emplace<md5_ctx>());
  else
    nettle_sha256_init(&state_->of.emplace<sha256_ctx>());
}
Digest::~Digest() = default;
Digest::Digest(Digest&&) noexcept = default;

void Digest::push(std::string_view bytes) {
  const auto* first = reinterpret_cast<const std::uint8_t*>(bytes.data());
  if (auto* md5 = std::get_if<md5_ctx>(&state_->of))
    nettle_md5_update(md5, bytes.size(), first);
  else
    nettle_sha256_update(&std::get<sha256_ctx>(state_->of), bytes.size(), first);
}

std::string Digest::finish() {
  auto* md5 = std::get_if<md5_ctx>(&state_->of);
  std::string digest(md5 != nullptr ? MD5_DIGEST_SIZE : SHA256_DIGEST_SIZE, '\0');
  auto* first = reinterpret_cast<std::uint8_t*>(digest.data());
  if (md5 != nullptr)
    nettle_md5_digest(md5, digest.size(), first);
  else
    nettle_sha256_digest(&std::get<sha256_ctx>(state_->of), digest.size(), first);
  return digest;
}

}  // namespace dsp
