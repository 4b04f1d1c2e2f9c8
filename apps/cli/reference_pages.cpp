#include "apps/cli/reference_pages.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/cli/command_page.hpp"
#include "apps/config/config.hpp"
#include "apps/process/version.hpp"
#include "apps/reference/guides.hpp"
#include "apps/reference/topics.hpp"

namespace apps {
namespace {

std::vector<std::string> command_names(const Program& program) {
  std::vector<std::string> names;
  for (const Command* command : visible_commands(program)) names.push_back(command->name);
  return names;
}

std::vector<std::string> help_topics(const Program& program) {
  std::vector<std::string> names;
  for (const Page& page : topic_pages()) names.push_back(page.name);
  for (const Guide& guide : guides) names.emplace_back(guide.name);
  names.emplace_back("reference");
  for (const std::string& name : command_names(program)) names.push_back(name);
  return names;
}

/// In single quotes for a shell.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

/// A description in a specification of zsh's _arguments, where brackets and colons have a meaning.
std::string zsh_escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':') result += '\\';
    result += c;
  }
  return result;
}

std::string zsh_values(const Option& option) {
  const std::string value = value_name(option);
  if (const auto& words = option.value.words; !words.empty())
    return fmt::format(":{}:({})", zsh_escaped(value), fmt::join(words, " "));
  const bool file = value == "DIR" || value == "TEXT";
  return value.empty() ? "" : fmt::format(":{}:{}", zsh_escaped(value), file ? "_files" : "");
}

std::string zsh_arguments(const Command& command, const std::vector<std::string>& topics) {
  std::string arguments, options;
  for (const Option& option : command.options) {
    const std::vector<std::string> names = names_of(option);
    if (names.empty()) {
      const std::string action = command.name == "help" ? fmt::format("({})", fmt::join(topics, " ")) : "_files";
      arguments += " \\\n        " + quoted(fmt::format("*:{}:{}", zsh_escaped(option.names), action));
    }
    for (const std::string& name : names)
      options += " \\\n        " + quoted(fmt::format("*{}[{}]{}", name, zsh_escaped(option.help), zsh_values(option)));
  }
  return arguments + options;
}

}  // namespace

std::string reference_markdown(const Program& program) {
  std::string text =
      "# Reference of Ardent\n\nWritten by `ardent help reference`; do not edit. Settings first, then commands.\n";
  for (const Page& page : topic_pages()) text += "\n" + to_markdown(page, 2);
  text += "\n" + to_markdown(page_of(program), 2);
  for (const Command* command : visible_commands(program)) text += "\n" + to_markdown(page_of(*command), 2);
  return text;
}

std::map<std::string, std::string> manual_pages(const Program& program) {
  std::map<std::string, std::string> pages{{"ardent.1", to_manual(page_of(program), 1, version())}};
  for (const Command* command : visible_commands(program))
    pages[fmt::format("ardent-{}.1", command->name)] = to_manual(page_of(*command), 1, version());
  for (const Page& page : topic_pages()) pages[fmt::format("ardent-{}.5", page.name)] = to_manual(page, 5, version());
  return pages;
}

std::string bash_completion(const Program& program) {
  std::string options, values;
  for (const Command* command : visible_commands(program)) {
    std::vector<std::string> names;
    for (const Option& option : command->options)
      for (const std::string& name : names_of(option)) {
        names.push_back(name);
        if (const auto& words = option.value.words; !words.empty())
          values += fmt::format("    {}:{}) COMPREPLY=($(compgen -W '{}' -- \"$word\")); return ;;\n", command->name,
                                name, fmt::join(words, " "));
      }
    options += fmt::format("    {}) options='{}' ;;\n", command->name, fmt::join(names, " "));
  }
  return fmt::format(R"bash(# Completion of ardent in bash, written by `ardent completion bash`.
_ardent() {{
  local word="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}" command="${{COMP_WORDS[1]}}" options=
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W '{} --help --version' -- "$word"))
    return
  fi
  case "$command:$before" in
{}    help:help) COMPREPLY=($(compgen -W '{}' -- "$word")); return ;;
    completion:completion) COMPREPLY=($(compgen -W 'bash zsh' -- "$word")); return ;;
    check:--set|run:--set|prep:--set|study:--set|study:--over|batch:--set)
      COMPREPLY=($(compgen -W '{}=' -- "$word")); compopt -o nospace 2>/dev/null; return ;;
  esac
  case "$command" in
{}  esac
  case "$word" in
    -*) COMPREPLY=($(compgen -W "$options" -- "$word")) ;;
    *) COMPREPLY=($(compgen -f -- "$word")) ;;
  esac
}}
complete -o filenames -F _ardent ardent
)bash",
                     fmt::join(command_names(program), " "), values, fmt::join(help_topics(program), " "),
                     fmt::join(override_keys(), "= "), options);
}

std::string zsh_completion(const Program& program) {
  std::string commands, cases;
  for (const Command* command : visible_commands(program)) {
    commands += fmt::format("    {}\n", quoted(command->name + ":" + command->help));
    cases += fmt::format("      {})\n        _arguments{} ;;\n", command->name,
                         zsh_arguments(*command, help_topics(program)));
  }
  return fmt::format(R"zsh(#compdef ardent
# Completion of ardent in zsh, written by `ardent completion zsh`.
_ardent() {{
  local -a commands
  commands=(
{})
  if (( CURRENT == 2 )); then
    _describe command commands
  else
    local command=$words[2]
    shift words
    (( CURRENT-- ))
    case $command in
{}    esac
  fi
}}
_ardent "$@"
)zsh",
                     commands, cases);
}

}  // namespace apps
