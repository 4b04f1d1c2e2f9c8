#include "dsp/io/sound_bytes.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "dsp/io/input_file.hpp"

namespace dsp {

void SoundBytes::patch(std::uint64_t offset, std::string bytes) {
  patched_at_ = static_cast<std::int64_t>(offset);
  patch_ = std::move(bytes);
}

std::int64_t SoundBytes::seek(std::int64_t offset, int whence) {
  const auto base = whence == SEEK_CUR ? position_ : whence == SEEK_END ? size_ : 0;
  if (offset < -base) return -1;
  return position_ = base + offset;
}

std::int64_t SoundBytes::read(void* into, std::int64_t count) {
  if (error_ || position_ >= size_) return 0;
  auto* out = static_cast<char*>(into);
  std::int64_t got = 0;
  try {
    got = static_cast<std::int64_t>(file_->read(static_cast<std::uint64_t>(begin_ + position_), out,
                                                static_cast<std::size_t>(std::min(count, size_ - position_))));
  } catch (...) {
    error_ = std::current_exception();
  }
  const auto from = std::max(position_, patched_at_);
  const auto to = std::min(position_ + got, patched_at_ + static_cast<std::int64_t>(patch_.size()));
  for (auto at = from; at < to; ++at) out[at - position_] = patch_[static_cast<std::size_t>(at - patched_at_)];
  position_ += got;
  return got;
}

}  // namespace dsp
