#include "dsp/io/text_lines.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dsp/values/fault.hpp"

namespace dsp {

bool TextLines::fill() {
  constexpr std::uint64_t most_bytes = std::uint64_t{1} << 18;
  buffer_offset_ += begin_;
  buffer_.erase(0, begin_);
  begin_ = 0;
  const auto kept = buffer_.size();
  const auto read = buffer_offset_ + kept;
  // One byte more than is left: a file that has grown is seen at its end.
  const auto piece_bytes =
      static_cast<std::size_t>(std::min(most_bytes, file_->size() - std::min(read, file_->size()) + 1));
  buffer_.resize(kept + piece_bytes);
  buffer_.resize(kept + file_->read(read, buffer_.data() + kept, piece_bytes));
  return buffer_.size() > kept;
}

bool TextLines::next(std::string_view& line) {
  constexpr std::size_t most_bytes = std::size_t{1} << 20;
  auto end = buffer_.find('\n', begin_);
  while (end == std::string::npos) {
    const auto searched = buffer_.size() - begin_;
    if (searched > most_bytes)
      throw Fault(FaultKind::input, "table.line",
                  fmt::format("{}:{}: a line of more than 1 MiB: this is no table", file_->name(), number_ + 1));
    if (!fill()) break;
    end = buffer_.find('\n', searched);
  }
  if (begin_ == buffer_.size()) return false;
  ended_ = end != std::string::npos;
  line = std::string_view(buffer_).substr(begin_, ended_ ? end - begin_ : std::string::npos);
  offset_ = buffer_offset_ + begin_;
  begin_ += line.size() + (ended_ ? 1 : 0);
  ++number_;
  if (line.ends_with('\r')) line.remove_suffix(1);
  return true;
}

}  // namespace dsp
