#pragma once
#include <memory>
#include <string>
#include <string_view>

namespace dsp {

/// A digest of bytes as they come, by nettle.
class Digest {
 public:
  enum class Method { md5, sha256 };
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
