#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "apps/process/console.hpp"

namespace CLI {
class App;
}

namespace apps {

/// What is allowed anywhere on the command line, and that line itself.
struct GlobalOptions {
  std::filesystem::path output;  ///< -o; empty where it is not given
  bool quiet = false, json = false, dry_run = false, force = false, strict = false;
  int verbosity = 0, num_threads = 0;  ///< 0 threads: as many as there are processors
  std::uint64_t seed = 1;
  std::vector<std::string> set;
  ProgressMode progress = ProgressMode::automatic;
  std::vector<std::string> command_line;
};

/// Does what a command was asked for; returns the exit code. Throws dsp::Fault.
using CommandBody = std::function<int(const GlobalOptions&, Console&)>;

/// A global option without effect on a command: refused, not ignored.
struct UnusedOption {
  const char *name, *advice = "";
};

/// A command as `ardent --help` lists it.
struct Command {
  const char *name, *help;
  std::vector<UnusedOption> unused;
  /// Adds its own options to the parser; the body reads them once the command line is parsed.
  std::function<CommandBody(CLI::App&)> describe;
  const char* group = "";                  ///< what a person wants to do with it: its heading in `ardent --help`
  std::vector<const char*> examples = {};  ///< command lines
  const char* details = "";                ///< paragraphs below the usage
};

inline constexpr const char *look_group = "Look at a recording", *identify_group = "Find its equation of motion",
                            *use_group = "Use and compare equations", *made_group = "Without a recording of your own",
                            *help_group = "Help";

/// All of them, in the order of `ardent --help`.
[[nodiscard]] std::vector<Command> commands();

/// The options that may stand anywhere on the command line, but those that a command takes no notice of.
void add_global_options(CLI::App& app, GlobalOptions& options, const std::vector<UnusedOption>& unused = {});

[[nodiscard]] int thread_count(const GlobalOptions& options);

/// -o DIR. Throws dsp::Fault (usage) where it is not given.
[[nodiscard]] const std::filesystem::path& required_output(const GlobalOptions& options, const char* command);

[[nodiscard]] Command batch_command();
[[nodiscard]] Command check_command();
[[nodiscard]] Command compare_command();
[[nodiscard]] Command completion_command();
[[nodiscard]] Command fit_command();
[[nodiscard]] Command help_command();
[[nodiscard]] Command info_command();
[[nodiscard]] Command init_command();
[[nodiscard]] Command manual_command();
[[nodiscard]] Command merge_command();
[[nodiscard]] Command predict_command();
[[nodiscard]] Command prepare_command();
[[nodiscard]] Command replicate_command();
[[nodiscard]] Command report_command();
[[nodiscard]] Command response_command();
[[nodiscard]] Command run_command();
[[nodiscard]] Command simulate_command();
[[nodiscard]] Command study_command();
[[nodiscard]] Command terms_command();

}  // namespace apps
