#pragma once
#include <memory>
#include <string>
#include <string_view>

namespace dsp {

/// A digest of bytes as they come, by OpenSSL.
class Digest {
 public:
  enum class Method { md5, sha256 };
  /// Throws Fault (numerics, system.no_library) where OpenSSL is not installed.
  explicit Digest(Method method);
  ~Digest();
  Digest(Digest&&) noexcept;
  void push(std::string_view bytes);
  /// 16 or 32 bytes; nothing can be pushed afterwards.
  [[nodiscard]] std::string finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace dsp
