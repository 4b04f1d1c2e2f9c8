#pragma once
#include <string>
#include <vector>

#include "apps/process/console.hpp"

namespace apps {

/// Parses the command line, does what it says and reports how it ended. Returns the exit code: 0 fine; 2 wrong usage or
/// config; 3 input unusable; 4 numerical failure; 5 cannot write; 1 our own mistake; 130, 143 on SIGINT, SIGTERM.
int run_command_line(int argc, const char* const* argv);

/// Does what the words behind `ardent` say, within a program that is not ours. Returns the exit code of a command that
/// came to its end, whose results and messages `console` has. Throws dsp::Fault: as the commands, and usage
/// ("command.process") for one that would start this program again; Interrupted; std::bad_alloc and std::length_error
/// where there is no memory; std::system_error where the system refuses.
int do_command(const std::vector<std::string>& words, Console& console);

}  // namespace apps
