#pragma once
#include <sys/types.h>

#include <chrono>
#include <string>
#include <vector>

#include "apps/process/folder.hpp"

namespace apps {

/// How a child came to its end.
struct ChildEnd {
  int exit_code = 0;     ///< 0 where a signal ended it
  int signal = 0;        ///< 0: none
  std::string out, err;  ///< the last 64 KiB of what it wrote
};

/// This program once more, as a process of its own: what kills it costs nobody else anything. It never outlives this
/// one: however we end, the system kills it.
class ChildProcess {
 public:
  /// `arguments` behind the program's name. Throws std::system_error where the system gives no process.
  explicit ChildProcess(const std::vector<std::string>& arguments);
  /// Ends it by SIGTERM, upon which it clears what it was writing, and waits for it.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  /// Takes what it has written so far; true once it has ended.
  [[nodiscard]] bool ended();
  /// Of one that has ended; it is then gone.
  [[nodiscard]] ChildEnd take();
  /// Returns when one of them has written something or ended, a signal has come, or after this time.
  static void wait_for_any(const std::vector<ChildProcess*>& children, std::chrono::milliseconds longest);

 private:
  struct Stream {
    Descriptor descriptor{};
    std::string text{};
    void read();
  };
  pid_t pid_ = -1;
  int status_ = 0;
  Stream out_, err_;
};

}  // namespace apps
