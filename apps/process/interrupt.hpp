#pragma once
#include <csignal>

namespace apps {

/// A person or the system asked the program to stop: unwinds to main, removing unfinished files on its way.
struct Interrupted {
  int signal = 0;
};

/// SIGINT, SIGTERM and SIGHUP set a flag (the second one ends the program at once); SIGHUP stays ignored where it is,
/// as by nohup. SIGPIPE and SIGXFSZ become write errors.
void install_signal_handlers();

/// While it lives SIGINT sets that flag, however often it comes, in a program that is not ours; after that the
/// program's own handler is back, and the flag is gone. For the thread that the program has its signals in.
class InterruptScope {
 public:
  InterruptScope();
  ~InterruptScope();
  InterruptScope(const InterruptScope&) = delete;
  InterruptScope& operator=(const InterruptScope&) = delete;

 private:
  struct sigaction before_ {};
};

/// Throws Interrupted if a signal has come. Called between blocks of work.
void check_interrupted();

}  // namespace apps
