#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/process/console.hpp"

namespace apps {

/// `ardent run|prep|check INPUT ...` as it was typed.
struct RunArguments {
  std::filesystem::path input, folder;  ///< folder empty: NAME-run in the current folder
  bool force = false, dry_run = false, strict = false;
  bool salvage = false, uncalibrated = false;
  int num_threads = 1;
  std::size_t max_memory_bytes = 0;  ///< 0: the default
  std::uint64_t seed = 1;            ///< written into the manifest; nothing here is random
  std::vector<std::string> set;      ///< "a.b=c"
  std::vector<std::string> command_line;
};

/// Recording to judged equation; writes the run folder, prints the equations. Returns the exit code: 4 where no method
/// selected anything on some range. Throws dsp::Fault.
int run_identification(const RunArguments& arguments, Console& console);

/// Calibration, decimation, motion and segments only.
void run_preparation(const RunArguments& arguments, Console& console);

/// All that a run checks, nothing written. Throws the dsp::Fault a run would stop at.
void run_check(const RunArguments& arguments, Console& console);

}  // namespace apps
