#pragma once
#include <fcntl.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "support/scratch.hpp"

namespace support {

struct Ended {
  int code = 0;  ///< exit code, or 128 + signal
  std::string out, err;
  long peak_kb = 0;  ///< most memory it held at a time
};

/// A shell command under way in a folder, "$ARDENT" being the built program.
class Running {
 public:
  Running(const std::filesystem::path& folder, const std::string& command) {
    ::malloc_trim(0);  // the most memory of a child begins with what it is a copy of
    pid_ = ::fork();
    if (pid_ < 0) throw std::runtime_error("no process");
    if (pid_ > 0) return;
    const auto redirect = [](const std::filesystem::path& file, int descriptor) {
      ::dup2(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), descriptor);
    };
    redirect(out_ / "out", STDOUT_FILENO);
    redirect(out_ / "err", STDERR_FILENO);
    ::setenv("ARDENT", ARDENT_PROGRAM, 1);
    if (::chdir(folder.c_str()) == 0) ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    ::_exit(127);
  }
  void send(int signal) const { ::kill(pid_, signal); }
  [[nodiscard]] pid_t pid() const { return pid_; }
  Ended wait() {
    int status = 0;
    rusage used{};
    ::wait4(pid_, &status, 0, &used);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), bytes_of(out_ / "out"),
            bytes_of(out_ / "err"), used.ru_maxrss};
  }

 private:
  Scratch out_;
  pid_t pid_ = 0;
};

/// What is checked in a folder where a command has ended well; none: nothing.
inline void (*after_run)(const std::filesystem::path& folder) = nullptr;

/// Runs a shell command in a folder to its end.
inline Ended run(const Scratch& folder, const std::string& command) {
  Ended ended = Running(folder / "", command).wait();
  if (ended.code == 0 && after_run != nullptr) after_run(folder / "");
  return ended;
}

/// The same, where it must end with this exit code and say these pieces on either stream.
inline Ended expect(const Scratch& folder, const std::string& command, int code,
                    const std::vector<std::string>& pieces) {
  CAPTURE(command);
  const Ended ended = run(folder, command);
  CAPTURE(ended.err);
  CHECK(ended.code == code);
  for (const std::string& piece : pieces) CHECK_THAT(ended.err + ended.out, Catch::Contains(piece));
  return ended;
}

/// Waits until `condition` holds; false after two minutes.
template <class Condition>
bool eventually(Condition&& condition) {
  for (int i = 0; i < 60000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

}  // namespace support
