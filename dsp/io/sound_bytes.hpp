#pragma once
#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "dsp/io/input_file.hpp"

namespace dsp {

/// A sound file as a decoder sees it: read ahead in pieces that the processor's cache holds until they are taken, with
/// patches where sizes had to be put right. A decoder written in C must not see exceptions, so a read error is kept,
/// looks like the end of the file, and is thrown by rethrow().
class SoundBytes {
 public:
  /// A head that is not empty replaces the first `replaced` bytes.
  SoundBytes(std::unique_ptr<InputFile> file, std::string head, std::uint64_t replaced)
      : file_(std::move(file)),
        head_(std::move(head)),
        shift_(head_.empty() ? 0 : static_cast<std::int64_t>(replaced - head_.size())) {}
  [[nodiscard]] std::int64_t size() const { return static_cast<std::int64_t>(file_->size()) - shift_; }
  [[nodiscard]] const InputFile& file() const& { return *file_; }
  void file() const&& = delete;
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }
  /// As lseek: whence is SEEK_SET, SEEK_CUR or SEEK_END.
  std::int64_t seek(std::int64_t offset, int whence);
  std::int64_t read(void* into, std::int64_t count);
  [[nodiscard]] std::int64_t tell() const { return position_; }

 private:
  bool fill();

  std::unique_ptr<InputFile> file_;
  std::string head_;
  std::int64_t shift_ = 0;  ///< from a position here to the one in the file
  std::vector<char> buffer_;
  std::int64_t position_ = 0, start_ = 0, length_ = 0;
  std::exception_ptr error_;
};

}  // namespace dsp
