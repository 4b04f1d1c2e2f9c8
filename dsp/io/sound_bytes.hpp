#pragma once
#include <cstdint>
#include <exception>
#include <string>

namespace dsp {

class InputFile;

/// Bytes [begin, end) of a sound file as libsndfile sees them. A decoder written in C must not see exceptions, so a
/// read error is kept, looks like the end of the file, and is thrown by rethrow().
class SoundBytes {
 public:
  SoundBytes(const InputFile& file, std::uint64_t begin, std::uint64_t end)
      : file_(&file), begin_(static_cast<std::int64_t>(begin)), size_(static_cast<std::int64_t>(end - begin)) {}
  /// What is read at `offset` instead of what stands there, where a size was to be put right.
  void patch(std::uint64_t offset, std::string bytes);
  [[nodiscard]] std::int64_t size() const { return size_; }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }
  /// As lseek: whence is SEEK_SET, SEEK_CUR or SEEK_END.
  std::int64_t seek(std::int64_t offset, int whence);
  std::int64_t read(void* into, std::int64_t count);
  [[nodiscard]] std::int64_t tell() const { return position_; }

 private:
  const InputFile* file_;
  std::int64_t begin_, size_, position_ = 0;
  std::int64_t patched_at_ = 0;
  std::string patch_;
  std::exception_ptr error_;
};

}  // namespace dsp
