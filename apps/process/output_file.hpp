#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace apps {

/// When the bytes of a file are on the disk: when it is closed, or, as then they are only on their way, after
/// sync_entry. So many files take little longer than one.
enum class OnDisk { when_closed, later };

/// A new file, written through a buffer. What is at its place already is neither followed nor overwritten. Every
/// failure of the system is dsp::Fault (output, "output.write") with the reason and what to try.
class OutputFile {
 public:
  /// `shown`: what messages call the file, which moves there when all is written.
  OutputFile(const std::filesystem::path& path, std::filesystem::path shown, OnDisk on_disk = OnDisk::when_closed);
  ~OutputFile();
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  void write(std::string_view bytes);
  void close();

 private:
  void flush();
  std::filesystem::path shown_;
  std::string buffer_;
  int descriptor_ = -1;
  OnDisk on_disk_;
};

/// All of a small file at once.
void write_file(const std::filesystem::path& path, const std::filesystem::path& shown, std::string_view bytes,
                OnDisk on_disk = OnDisk::when_closed);

}  // namespace apps
