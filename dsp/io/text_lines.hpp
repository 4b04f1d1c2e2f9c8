#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "dsp/io/input_file.hpp"

namespace dsp {

/// The lines of a text file, one at a time, with their numbers.
class TextLines {
 public:
  /// `offset` is the first byte of line number `line`.
  explicit TextLines(const InputFile& file, std::uint64_t offset = 0, std::int64_t line = 1)
      : file_(&file), buffer_offset_(offset), number_(line - 1) {}
  /// The next line without its end (\n or \r\n); valid until the next call. False at the end of the file.
  /// Throws Fault table.line (input) for a line of more than 1 MiB.
  bool next(std::string_view& line);
  [[nodiscard]] std::int64_t number() const { return number_; }   ///< of the line last returned
  [[nodiscard]] std::uint64_t offset() const { return offset_; }  ///< of its first byte
  [[nodiscard]] bool ended() const { return ended_; }             ///< whether it had a line end

 private:
  bool fill();

  const InputFile* file_;
  std::string buffer_;
  std::uint64_t buffer_offset_;  ///< of buffer_[0] in the file
  std::size_t begin_ = 0;        ///< of what has not been returned yet
  std::int64_t number_;
  std::uint64_t offset_ = 0;
  bool ended_ = true;
};

}  // namespace dsp
