#include "apps/cli/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <sstream>
#include <string_view>

#include "apps/cli/command.hpp"
#include "apps/cli/command_page.hpp"
#include "apps/process/ending.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/process/standard_streams.hpp"
#include "apps/process/version.hpp"

namespace apps {
namespace {

void refuse_unused(const CLI::App& app, const Command& command) {
  for (const UnusedOption& option : command.unused)
    if (app.get_option(option.name)->count() > 0)
      throw dsp::Fault(dsp::FaultKind::usage, "usage",
                       fmt::format("{}: {} has no effect on this command. Leave it out{}", command.name, option.name,
                                   option.advice));
}

/// The commands of the program. Those that the command line names get their options; help, completion and the like need
/// the options of all. To describe all commands takes half of a short command's time.
class Parser {
 public:
  Parser(CLI::App& app, GlobalOptions& global) : app_(app), global_(global), all_(commands()), bodies_(all_.size()) {
    for (const Command& command : all_)
      added_.push_back(app.add_subcommand(command.name, command.help)->group(command.group));
    const std::vector<std::string>& words = global.command_line;
    const auto is_named = [&](const Command& command) {
      return std::find(words.begin(), words.end(), command.name) != words.end();
    };
    for (std::size_t i = 0; i < all_.size(); ++i)
      if (is_named(all_[i])) describe(i);
    const auto looks_at_all = [](const Command& command) {
      return command.group == std::string_view(help_group) || command.group[0] == '\0';
    };
    if (std::any_of(all_.begin(), all_.end(), [&](const Command& one) { return is_named(one) && looks_at_all(one); }))
      describe_rest();
  }
  /// Reads the command line; false where the help or the version was asked for, and printed.
  bool parse(int argc, const char* const* argv, Console& console) {
    try {
      app_.parse(argc, argv);
      return true;
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() != 0) {
        describe_rest();  // for suggestions from other commands
        throw dsp::Fault(dsp::FaultKind::usage, "usage", usage_message(app_, error));
      }
      std::ostringstream text;  // --help, --version
      app_.exit(error, text);
      console.result(text.str());
      return false;
    }
  }
  /// Does what the command does that was named.
  int run(Console& console) const {
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (!app_.got_subcommand(added_[i])) continue;
      refuse_unused(app_, all_[i]);
      return bodies_[i](global_, console);
    }
    return 0;
  }

 private:
  void describe(std::size_t i) {
    if (bodies_[i]) return;
    bodies_[i] = all_[i].describe(*added_[i]);
    add_global_options(*added_[i], global_, all_[i].unused);
  }
  void describe_rest() {
    for (std::size_t i = 0; i < all_.size(); ++i) describe(i);
  }

  CLI::App& app_;
  GlobalOptions& global_;
  std::vector<Command> all_;
  std::vector<CLI::App*> added_;
  std::vector<CommandBody> bodies_;  ///< empty: not described yet
};

/// Does what the command line says. Until it is read, `console` is one of its own.
int run(int argc, const char* const* argv, Console& console) {
  CLI::App app("From raw vibration recordings to an equation of motion with error bars", "ardent");
  app.require_subcommand(1);
  app.fallthrough();
  app.set_version_flag("--version", version_text(), "Print the versions of the program and its libraries.");
  app.formatter_fn(
      [](const CLI::App* shown, const std::string&, CLI::AppFormatMode) { return to_text(page_of(*shown)); });
  GlobalOptions global;
  global.command_line.assign(argv + std::min(argc, 1), argv + argc);
  add_global_options(app, global);
  Parser parser(app, global);
  if (!parser.parse(argc, argv, console)) return 0;
  console =
      Console({.verbosity = global.quiet ? -1 : global.verbosity, .json = global.json, .progress = global.progress});
  return parser.run(console);
}

}  // namespace

std::vector<Command> commands() {
  return {info_command(),  check_command(),    init_command(),       run_command(),     prepare_command(),
          study_command(), batch_command(),    report_command(),     compare_command(), predict_command(),
          merge_command(), response_command(), simulate_command(),   fit_command(),     replicate_command(),
          terms_command(), help_command(),     completion_command(), manual_command()};
}

int run_command_line(int argc, const char* const* argv) {
  reserve_standard_streams();
  install_signal_handlers();
  Console console(ConsoleOptions{
      .json = std::any_of(argv, argv + argc, [](std::string_view argument) { return argument == "--json"; })});
  const auto action = [&] { return run(argc, argv, console); };
  return ending_of(std::ref(action), console);  // by reference: a copy might find no memory
}

}  // namespace apps
