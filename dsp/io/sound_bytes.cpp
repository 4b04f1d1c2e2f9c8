#include "dsp/io/sound_bytes.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace dsp {

std::int64_t SoundBytes::seek(std::int64_t offset, int whence) {
  const auto base = whence == SEEK_CUR ? position_ : whence == SEEK_END ? size() : 0;
  if (offset < -base) return -1;
  return position_ = base + offset;
}

std::int64_t SoundBytes::read(void* into, std::int64_t count) {
  auto* out = static_cast<char*>(into);
  std::int64_t done = 0;
  while (done < count && !error_) {
    if ((position_ < start_ || position_ >= start_ + length_) && !fill()) break;
    const auto piece = std::min(count - done, start_ + length_ - position_);
    std::memcpy(out + done, buffer_.data() + (position_ - start_), static_cast<std::size_t>(piece));
    position_ += piece;
    done += piece;
  }
  return done;
}

bool SoundBytes::fill() {
  constexpr std::size_t piece_bytes = std::size_t{1} << 15;
  start_ = position_;
  const auto head_bytes = static_cast<std::int64_t>(head_.size());
  if (start_ < head_bytes) {
    buffer_.assign(head_.begin() + start_, head_.end());
    length_ = head_bytes - start_;
    return true;
  }
  buffer_.resize(piece_bytes);
  length_ = 0;
  try {
    const auto from = static_cast<std::uint64_t>(start_ + shift_);
    length_ = static_cast<std::int64_t>(file_->read(from, buffer_.data(), buffer_.size()));
  } catch (...) {
    error_ = std::current_exception();
  }
  return length_ > 0;
}

}  // namespace dsp
