#pragma once
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/cli/command_line.hpp"

namespace fuzz {

/// The program with these arguments; exit code 1 is a mistake of ours, whatever they are.
inline void run_program(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv{"ardent"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  if (apps::run_command_line(static_cast<int>(argv.size()), argv.data()) == 1)
    throw std::logic_error("the program calls it a mistake of its own");
}

/// Two seconds of a linear oscillator and the force that drives it: a recording, and a table for `fit`.
[[nodiscard]] std::string small_record();

/// Works in another folder as long as it lives.
class WorkingFolder {
 public:
  explicit WorkingFolder(const std::filesystem::path& folder) : before_(std::filesystem::current_path()) {
    std::filesystem::current_path(folder);
  }
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;
  ~WorkingFolder() {
    std::error_code ignored;
    std::filesystem::current_path(before_, ignored);
  }

 private:
  std::filesystem::path before_;
};

}  // namespace fuzz
