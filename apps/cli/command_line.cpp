#include "apps/cli/command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <string_view>

#include "apps/cli/command.hpp"
#include "apps/cli/command_page.hpp"
#include "apps/cli/ending.hpp"
#include "apps/process/interrupt.hpp"
#include "apps/process/kept_stream.hpp"
#include "apps/process/standard_streams.hpp"
#include "apps/process/version.hpp"
#include "dsp/values/names.hpp"

// The only source that knows the parser of the command line.

namespace apps {
namespace {

bool is_argument(const Option& option) {
  return names_of(option).empty();
}

CLI::Option* add_target(CLI::App& app, const Option& option, bool* target) {
  return app.add_flag(option.names, *target);
}
CLI::Option* add_target(CLI::App& app, const Option& option, const std::function<void(const std::string&)>& target) {
  return app.add_option_function<std::string>(option.names, target);
}
/// Options before and after the command add up.
CLI::Option* add_target(CLI::App& app, const Option& option, std::vector<std::string>* target) {
  if (is_argument(option)) return app.add_option(option.names, *target);
  const auto append = [target](const std::vector<std::string>& given) {
    target->insert(target->end(), given.begin(), given.end());
  };
  return app.add_option_function<std::vector<std::string>>(option.names, append)->allow_extra_args(false);
}
template <typename T>
CLI::Option* add_target(CLI::App& app, const Option& option, T* target) {
  return app.add_option(option.names, *target);
}

void add_option(CLI::App& app, const Option& option) {
  const auto add = [&](const auto& target) -> CLI::Option* {
    if constexpr (std::is_same_v<decltype(target), const std::monostate&>)
      return nullptr;  // the parser has its own
    else
      return add_target(app, option, target);
  };
  CLI::Option* const added = std::visit(add, option.target);
  if (added == nullptr) return;
  const OptionValue& value = option.value;
  if (const std::string name = value_name(option); !name.empty() && !is_argument(option)) added->type_name(name);
  if (!value.words.empty()) added->check(CLI::IsMember(value.words));
  if (value.check) added->transform(CLI::Validator(value.check, ""));
  if (value.required) added->required();
  if (value.by_commas) added->delimiter(',');
}

/// Only commands that the command line names get their options: those of all take half of a short command's time.
void describe(CLI::App& app, const Program& program) {
  app.require_subcommand(1);
  app.fallthrough();
  app.set_version_flag("--version", version_text());
  for (const Option& option : program.options) add_option(app, option);
  const std::vector<std::string>& words = program.global->command_line;
  for (const Command& command : program.commands) {
    CLI::App& added = *app.add_subcommand(command.name);
    if (std::find(words.begin(), words.end(), command.name) == words.end()) continue;
    for (const Option& option : command.options) add_option(added, option);
  }
}

/// nullptr: none is named.
const Command* named_command(const CLI::App& app, const Program& program) {
  for (const Command& command : program.commands)
    if (app.got_subcommand(command.name)) return &command;
  return nullptr;
}

std::vector<std::string> option_names(const Command& command) {
  std::vector<std::string> all;
  for (const Option& option : command.options)
    for (const std::string& name : names_of(option)) all.push_back(name);
  return all;
}

/// A word that looks like an option and is none of this command.
std::string unknown_option(const Program& program, const Command& command, const std::string& typed) {
  const std::string name = typed.substr(0, typed.find('='));
  const std::string near = dsp::nearest(name, option_names(command));
  std::string text = fmt::format("{}: there is no option {}", command.name, dsp::clean_name(name));
  if (!near.empty()) return text + fmt::format(". Did you mean {}?", near);
  const std::vector<const Command*> all = visible_commands(program);
  if (std::any_of(all.begin(), all.end(), [&](const Command* one) {
        const std::vector<std::string> names = option_names(*one);
        return std::find(names.begin(), names.end(), name) != names.end();
      }))
    text += " here; other commands have it";
  return text + fmt::format(". See ardent {} --help", command.name);
}

std::string unknown_command(const Program& program, const std::vector<std::string>& words) {
  const auto typed = std::find_if(words.begin(), words.end(), [](const std::string& word) { return word[0] != '-'; });
  if (typed == words.end() && !words.empty())
    return fmt::format("there is no option {} before a command. See ardent --help", dsp::clean_name(words.front()));
  if (typed == words.end()) return "no command. ardent --help lists them; a first one: ardent info FILE";
  std::vector<std::string> names;
  for (const Command* command : visible_commands(program)) names.push_back(command->name);
  const std::string near = dsp::nearest(*typed, names);
  return fmt::format("there is no command '{}'. {}", dsp::clean_name(*typed),
                     near.empty()
                         ? fmt::format("There are {}. For a recording: ardent run FILE", fmt::join(names, ", "))
                         : fmt::format("Did you mean ardent {}?", near));
}

/// A sentence on what was typed wrongly: the nearest command or option, or what is missing.
std::string usage_message(const CLI::App& app, const Program& program, const CLI::ParseError& error) {
  std::vector<std::string> rest = app.remaining(true);
  std::erase(rest, "--");
  const Command* const command = named_command(app, program);
  if (command == nullptr) return unknown_command(program, rest);
  for (const std::string& word : rest)
    if (word.size() > 1 && word[0] == '-') return unknown_option(program, *command, word);
  std::string text = error.what();
  if (!rest.empty())
    text = fmt::format("'{}' is one argument too many", dsp::clean_name(rest.front()));
  else if (const std::size_t at = text.find(" not in {"); at != std::string::npos && text.ends_with('}'))
    text = fmt::format("{}, which is none of {}", text.substr(0, at), text.substr(at + 9, text.size() - at - 10));
  for (const Option& option : command->options)
    if (is_argument(option) && text.starts_with(option.names + " is required"))
      return fmt::format("{0}: {1} is missing. {1}: {2} See ardent {0} --help", command->name, option.names,
                         option.help);
  return fmt::format("{}: {}. See ardent {} --help", command->name, text, command->name);
}

void refuse_unused(const CLI::App& app, const Command& command) {
  for (const UnusedOption& option : command.unused)
    if (app.get_option(option.name)->count() > 0)
      throw dsp::Fault(dsp::FaultKind::usage, "usage",
                       fmt::format("{}: {} has no effect on this command. Leave it out{}", command.name, option.name,
                                   option.advice));
}

/// Recordings that come through pipes are kept: they are read more than once.
void keep_streams(const Command& command) {
  const auto keep = [](std::filesystem::path& path) {
    if (path.extension() != ".toml") path = kept_stream(path);
  };
  for (const Option& option : command.options) {
    if (!option.value.is_recording) continue;
    if (auto* const* path = std::get_if<std::filesystem::path*>(&option.target)) keep(**path);
    if (auto* const* paths = std::get_if<std::vector<std::filesystem::path>*>(&option.target))
      std::for_each((*paths)->begin(), (*paths)->end(), keep);
  }
}

/// Does what the command line says. Until it is read, `console` is one of its own.
int run(int argc, const char* const* argv, Console& console, bool is_program) {
  const Program program = make_program();
  GlobalOptions& global = *program.global;
  global.command_line.assign(argv + std::min(argc, 1), argv + argc);
  CLI::App app("", "ardent");
  describe(app, program);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    const Command* const command = named_command(app, program);
    console.result(to_text(command != nullptr ? page_of(*command) : page_of(program)));
    return 0;
  } catch (const CLI::CallForVersion&) {
    console.result(version_text() + "\n");
    return 0;
  } catch (const CLI::ParseError& error) {
    throw dsp::Fault(dsp::FaultKind::usage, "usage", usage_message(app, program, error));
  }
  const Command& command = *named_command(app, program);
  refuse_unused(app, command);
  if (command.starts_itself && !is_program)
    throw dsp::Fault(dsp::FaultKind::usage, "command.process",
                     fmt::format("{0} starts the program again for each recording, which is another one here. Run "
                                 "ardent {0} from a shell",
                                 command.name));
  const int verbosity = global.quiet ? -1 : global.verbose ? 1 : 0;
  console.set({.verbosity = verbosity, .json = global.json, .progress = global.progress});
  keep_streams(command);
  return command.run(global, console);
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  reserve_standard_streams();
  install_signal_handlers();
  Console console(ConsoleOptions{
      .json = std::any_of(argv, argv + argc, [](std::string_view argument) { return argument == "--json"; })});
  const auto action = [&] { return run(argc, argv, console, true); };
  return ending_of(std::ref(action), console);  // by reference: a copy might find no memory
}

int do_command(const std::vector<std::string>& words, Console& console) {
  std::vector<const char*> arguments{"ardent"};
  for (const std::string& word : words) arguments.push_back(word.c_str());
  return run(static_cast<int>(arguments.size()), arguments.data(), console, false);
}

}  // namespace apps
