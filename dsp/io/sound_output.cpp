#include "dsp/io/sound_output.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace dsp {

std::int64_t SoundOutput::seek(std::int64_t offset, int whence) {
  position_ = offset + (whence == SEEK_SET ? 0 : whence == SEEK_CUR ? position_ : size_);
  return position_;
}

std::int64_t SoundOutput::write(const void* bytes, std::int64_t count) {
  std::int64_t done = 0;
  while (done < count && error_ == 0) {
    const ssize_t written = ::pwrite(descriptor_, static_cast<const char*>(bytes) + done,
                                     static_cast<std::size_t>(count - done), position_);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      error_ = errno;
      break;
    }
    done += written;
    position_ += written;
  }
  size_ = std::max(size_, position_);
  return done;
}

}  // namespace dsp
