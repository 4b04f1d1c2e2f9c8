#pragma once

namespace apps {

/// A person or the system asked the program to stop: unwinds to main, removing unfinished files on its way.
struct Interrupted {
  int signal = 0;
};

/// SIGINT, SIGTERM and SIGHUP set a flag (the second one ends the program at once); SIGHUP stays ignored where it is,
/// as by nohup. SIGPIPE and SIGXFSZ become write errors.
void install_signal_handlers();

/// Throws Interrupted if a signal has come. Called between blocks of work.
void check_interrupted();

}  // namespace apps
