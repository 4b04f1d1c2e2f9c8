#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace apps {

/// A file that appears under its name whole or not at all: written to a new file beside it (O_EXCL, O_NOFOLLOW),
/// synced, then renamed. An older file of that name stays until then, and stays if anything fails. Every failure of the
/// system is dsp::Fault (output, "output.write") with the path, the reason and what to try.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path destination);
  /// Removes what was written unless it was committed.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  void write(std::string_view bytes);
  /// On return the bytes are on the disk under the destination's name.
  void commit();

 private:
  void flush();
  std::filesystem::path destination_, temporary_;
  std::string buffer_;
  int descriptor_ = -1;
};

/// All of a small file at once.
void write_file(const std::filesystem::path& destination, std::string_view bytes);

}  // namespace apps
