#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace dsp {

/// A regular file opened for reading and watched while it is read.
class InputFile {
 public:
  /// Throws Fault (input): file.missing, file.denied, file.kind (directory, pipe, device, ...: the message names it).
  /// Never waits for whoever may write to a pipe.
  /// `may_be_quoted`: messages may show what is in it.
  explicit InputFile(std::filesystem::path path, bool may_be_quoted = true);
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const& { return path_; }
  void path() const&& = delete;
  [[nodiscard]] const std::string& name() const& { return name_; }  ///< for messages
  void name() const&& = delete;
  [[nodiscard]] std::uint64_t size() const { return size_; }  ///< when opened
  /// From now on what is read is this text: the file's, in another encoding.
  void replace_by(std::string text);
  /// Bytes from offset on: `count`, or fewer at the end of the file. Throws Fault file.read where the device fails.
  std::size_t read(std::uint64_t offset, void* into, std::size_t count) const;
  [[nodiscard]] std::string text(std::uint64_t offset, std::size_t count) const;
  /// A piece of its text as messages show it: in quotes, or only how long it is where it may not be quoted.
  [[nodiscard]] std::string quoted(std::string_view piece) const;
  /// Throws Fault file.changed if size or time of the last change are no longer those found at opening.
  void check_unchanged() const;

 private:
  std::filesystem::path path_;
  std::string name_;
  struct Descriptor {
    int number = -1;
    ~Descriptor();
  } descriptor_;
  bool may_be_quoted_;
  std::uint64_t size_ = 0, size_on_disk_ = 0;
  std::optional<std::string> replaced_by_{};
  std::int64_t changed_s_ = 0, changed_ns_ = 0;
};

}  // namespace dsp
