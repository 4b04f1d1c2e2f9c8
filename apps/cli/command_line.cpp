#include "apps/cli/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <sstream>

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

/// Reads the command line; false where the help or the version was asked for, and printed.
bool parse(CLI::App& app, int argc, const char* const* argv, Console& console) {
  try {
    app.parse(argc, argv);
    return true;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) throw dsp::Fault(dsp::FaultKind::usage, "usage", usage_message(app, error));
    std::ostringstream text;  // --help, --version
    app.exit(error, text);
    console.result(text.str());
    return false;
  }
}

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
  const std::vector<Command> all = commands();
  std::vector<CommandBody> bodies;
  for (const Command& command : all) {
    CLI::App& added = *app.add_subcommand(command.name, command.help)->group(command.group);
    bodies.push_back(command.describe(added));
    add_global_options(added, global, command.unused);
  }
  if (!parse(app, argc, argv, console)) return 0;
  console =
      Console({.verbosity = global.quiet ? -1 : global.verbosity, .json = global.json, .progress = global.progress});
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!app.got_subcommand(all[i].name)) continue;
    refuse_unused(app, all[i]);
    return bodies[i](global, console);
  }
  return 0;
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
