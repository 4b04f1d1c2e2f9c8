#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "apps/process/folder.hpp"

namespace apps {

/// A new file, written through a buffer. What is at its place already is neither followed nor overwritten. When it is
/// closed its bytes are on their way to the disk, where StagingFolder::place waits for them. Every failure of the
/// system is dsp::Fault (output, "output.write") with the reason and what to try.
class OutputFile {
 public:
  /// By a relative path in a folder. `shown`: what messages call the file, which moves there when all is written.
  OutputFile(const Folder& folder, const std::filesystem::path& relative, std::filesystem::path shown);
  void write(std::string_view bytes);
  void close();

 private:
  void flush();
  std::filesystem::path shown_;
  std::string buffer_;
  Descriptor file_;
};

/// All of a small file at once.
void write_file(const Folder& folder, const std::filesystem::path& relative, const std::filesystem::path& shown,
                std::string_view bytes);

}  // namespace apps
