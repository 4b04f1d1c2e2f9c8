#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/cli/command.hpp"
#include "apps/config/config.hpp"
#include "apps/config/inputs.hpp"
#include "apps/output/run_folder.hpp"

namespace apps {

/// `ardent run|prep|check|study INPUT ...` as it was typed.
struct RunArguments {
  std::filesystem::path input, folder;       ///< folder empty: NAME-run in the current folder
  std::filesystem::path recording;           ///< in place of the config's own; empty: its own
  std::filesystem::path sidecar;             ///< of every recording; empty: as the config says
  bool no_rows = false, no_figures = false;  ///< what a run folder is to do without
  std::string require;                       ///< least verdict of every range: "describes", "in_part" or empty
  bool force = false, dry_run = false, strict = false;
  bool resume = false;  ///< an earlier run of the same inputs and settings stays as it is, any other is replaced
  bool salvage = false, uncalibrated = false;
  int num_threads = 1;
  std::size_t max_memory_bytes = 0;  ///< 0: the default
  std::uint64_t seed = 1;            ///< written into the manifest; nothing here is random
  std::vector<std::string> set;      ///< "a.b=c"
  std::vector<std::string> command_line;
};

/// The options that run, prep, check, study and batch have in common, behind the argument that names the input.
[[nodiscard]] std::vector<Option> run_options(
    RunArguments& typed, const char* input = "INPUT",
    const char* help = "A recording (- is standard input), or a config NAME.toml.");
/// --no-rows and --no-figures, of run and batch.
[[nodiscard]] std::vector<Option> less_options(RunArguments& typed);
/// `typed` with what the global options say.
[[nodiscard]] RunArguments with_global(RunArguments typed, const GlobalOptions& global);

/// The config with what the command line says of every recording.
[[nodiscard]] Config config_of(const RunArguments& arguments);

/// -o, or the input's name with `suffix`, once that is known to touch no input.
[[nodiscard]] std::filesystem::path folder_apart(const RunArguments& arguments, const Config& config,
                                                 const char* suffix);

/// For the manifest of a run folder.
[[nodiscard]] RunFolder::Origin origin_of(const RunArguments& arguments, std::string command, const Config& config);

/// What a run would do, from the headers of its recordings.
[[nodiscard]] std::string plan_text(const RunArguments& arguments, const Config& config);

/// Everything between the config and the columns.
struct Work {
  Config config;
  std::vector<Input> inputs;
};
[[nodiscard]] Work prepare_work(Config config, const RunArguments& arguments, Console& console);

}  // namespace apps
