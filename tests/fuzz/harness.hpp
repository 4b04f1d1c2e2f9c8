#pragma once
#include <filesystem>
#include <string>
#include <vector>

// A harness is one file that defines seeds() and run(). It is linked with libfuzzer.cpp for fuzzing (preset fuzz) and
// with replay.cpp for the ordinary tests. Executions share nothing: whatever a harness writes is written anew for each.

namespace fuzz {

/// Small inputs to begin with, made by our own writers where there are any.
[[nodiscard]] std::vector<std::string> seeds();

/// One execution. Whatever leaves it but a dsp::Fault is a finding: a crash, any other exception, no end.
void run(const std::string& input);

/// run() where a dsp::Fault is a good end.
void execute(const std::string& input);

/// Where argv has `--write-seeds FOLDER`: writes seeds() there, one a file, and ends the program.
void write_seeds_if_asked(int argc, const char* const* argv);

/// The parts of an input that is several texts; a line of "%%" is between two.
[[nodiscard]] std::vector<std::string> parts(const std::string& input);
[[nodiscard]] std::string joined(const std::vector<std::string>& parts);

/// A file without a place on a disk, for readers that want a path.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& content);
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile();
  [[nodiscard]] std::filesystem::path path() const;

 private:
  int descriptor_ = -1;
};

}  // namespace fuzz
