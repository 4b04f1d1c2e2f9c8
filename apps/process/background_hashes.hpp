#pragma once
#include <filesystem>
#include <future>
#include <map>
#include <string>
#include <thread>
#include <vector>

namespace apps {

/// SHA-256 of files that are being read, by a thread of its own that goes through them in the same order: the disk
/// delivers them once. Destroying it stops the thread.
class HashesBeside {
 public:
  /// One thread: there is none beside, and each file is hashed when it is asked for.
  HashesBeside(const std::vector<std::filesystem::path>& files, int num_threads);
  /// As sha256_file: of one of the files, waited for; of any other, hashed here and now.
  [[nodiscard]] std::string of(const std::filesystem::path& file);

 private:
  std::map<std::filesystem::path, std::shared_future<std::string>> hashes_;
  std::jthread thread_;
};

}  // namespace apps
