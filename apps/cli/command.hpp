#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "apps/cli/option_values.hpp"
#include "apps/process/console.hpp"

// Commands as data: parser, help, manual pages and completion are made of it.

namespace apps {

/// What is allowed anywhere on the command line, and that line itself.
struct GlobalOptions {
  std::filesystem::path output;  ///< -o; empty where it is not given
  bool quiet = false, verbose = false, json = false, dry_run = false, force = false, strict = false;
  int num_threads = 0;  ///< 0: as many as there are processors
  std::uint64_t seed = 1;
  std::vector<std::string> set;
  ProgressMode progress = ProgressMode::automatic;
  std::vector<std::string> command_line;
};

/// Where the value of an option goes, which says what may be typed: nothing (bool: a flag), a number, a text, or
/// several (vectors: arguments up to the end, options that are repeated). A function is given the text. None: --help,
/// --version.
using Target = std::variant<std::monostate, bool*, int*, std::uint64_t*, std::optional<double>*, std::string*,
                            std::optional<std::string>*, std::filesystem::path*, std::vector<std::string>*,
                            std::vector<std::filesystem::path>*, std::function<void(const std::string&)>>;

struct OptionValue {
  std::string name = {};                ///< "DIR", for help; empty: NUMBER or TEXT
  std::string preset = {};              ///< what holds where the option is left out, for help
  std::vector<std::string> words = {};  ///< the value is one of these; none: anything
  ValueCheck check = {};
  bool required = false, by_commas = false;  ///< by_commas: one text may hold several
  bool is_recording = false;                 ///< "-" is standard input, and a pipe will do
};

struct Option {
  std::string names;  ///< "-o,--output"; of an argument "INPUT"
  Target target;
  std::string help;
  OptionValue value = {};
};
/// `more` behind `options`.
[[nodiscard]] std::vector<Option> joined(std::vector<Option> options, const std::vector<Option>& more);

/// A global option without effect on a command: refused, not ignored.
struct UnusedOption {
  std::string name, advice = "";
};

struct Command {
  std::string name, help;
  std::string group = "";  ///< what a person wants to do with it: its heading in `ardent --help`; none: not shown
  std::vector<UnusedOption> unused = {};
  std::vector<Option> options = {};  ///< their targets live as long as `run`
  /// Does what was asked for, once the targets of the options are filled; returns the exit code. Throws dsp::Fault.
  std::function<int(const GlobalOptions&, Console&)> run = {};
  std::vector<std::string> more = {};      ///< lines below the options
  std::vector<std::string> examples = {};  ///< command lines
  std::string details = "";                ///< paragraphs below the usage
  bool starts_itself = false;              ///< it runs this program once more, for each recording
};

inline constexpr const char *look_group = "Look at a recording", *identify_group = "Find its equation of motion",
                            *use_group = "Use and compare equations", *made_group = "Without a recording of your own",
                            *help_group = "Help";

/// What may be typed.
struct Program {
  std::shared_ptr<GlobalOptions> global;
  std::vector<Option> options;    ///< before a command
  std::vector<Command> commands;  ///< in the order of `ardent --help`, each with the global options that it takes
};
[[nodiscard]] Program make_program();

[[nodiscard]] int thread_count(const GlobalOptions& options);

/// -o DIR. Throws dsp::Fault (usage) where it is not given.
[[nodiscard]] std::filesystem::path required_output(const GlobalOptions& options, const char* command);

[[nodiscard]] Command batch_command();
[[nodiscard]] Command check_command();
[[nodiscard]] Command compare_command();
[[nodiscard]] Command completion_command();
[[nodiscard]] Command export_command();
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
