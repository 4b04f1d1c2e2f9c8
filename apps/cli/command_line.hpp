#pragma once

namespace apps {

/// Parses the command line, does what it says and reports how it ended. Returns the exit code: 0 fine; 2 wrong usage or
/// config; 3 input unusable; 4 numerical failure; 5 cannot write; 1 our own mistake; 130, 143 on SIGINT, SIGTERM.
int run_command_line(int argc, const char* const* argv);

}  // namespace apps
