#pragma once
#include <cstdint>

namespace dsp {

/// An open file as an encoder written in C sees it, by position. libsndfile forgets errors of the header it writes last
/// when it closes, so the first error of any write is kept here.
class SoundOutput {
 public:
  explicit SoundOutput(int descriptor) : descriptor_(descriptor) {}
  /// errno of the first write that failed, or 0.
  [[nodiscard]] int error() const { return error_; }
  [[nodiscard]] std::int64_t size() const { return size_; }
  [[nodiscard]] std::int64_t tell() const { return position_; }
  /// As lseek: whence is SEEK_SET, SEEK_CUR or SEEK_END.
  std::int64_t seek(std::int64_t offset, int whence);
  std::int64_t write(const void* bytes, std::int64_t count);

 private:
  int descriptor_, error_ = 0;
  std::int64_t position_ = 0, size_ = 0;
};

}  // namespace dsp
