#include "apps/cli/reference_pages.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/cli/command_page.hpp"
#include "apps/process/version.hpp"
#include "apps/reference/guides.hpp"
#include "apps/reference/topics.hpp"

namespace apps {
namespace {

std::vector<std::string> command_names(const CLI::App& root) {
  std::vector<std::string> names;
  for (const CLI::App* command : visible_commands(root)) names.push_back(command->get_name());
  return names;
}

std::vector<std::string> help_topics(const CLI::App& root) {
  std::vector<std::string> names;
  for (const Page& page : topic_pages()) names.push_back(page.name);
  for (const Guide& guide : guides) names.emplace_back(guide.name);
  names.emplace_back("reference");
  for (const std::string& name : command_names(root)) names.push_back(name);
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

std::string zsh_values(const OptionHelp& help) {
  if (!help.words.empty()) return fmt::format(":{}:({})", zsh_escaped(help.value), fmt::join(help.words, " "));
  const bool file = help.value == "DIR" || help.value == "TEXT" || help.names.empty();
  return help.value.empty() ? "" : fmt::format(":{}:{}", zsh_escaped(help.value), file ? "_files" : "");
}

std::string zsh_arguments(const CLI::App& command, const std::vector<std::string>& topics) {
  std::string text;
  for (const OptionHelp& help : options_of(command)) {
    if (help.names.empty()) {
      const std::string action = command.get_name() == "help" ? fmt::format("({})", fmt::join(topics, " ")) : "_files";
      text += " \\\n        " + quoted(fmt::format("*:{}:{}", zsh_escaped(help.value), action));
    }
    for (const std::string& name : help.names)
      text += " \\\n        " + quoted(fmt::format("*{}[{}]{}", name, zsh_escaped(help.meaning), zsh_values(help)));
  }
  return text;
}

}  // namespace

std::string reference_markdown(const CLI::App& root) {
  std::string text =
      "# Reference of Ardent\n\nWritten by `ardent help reference`; do not edit. Settings first, then commands.\n";
  for (const Page& page : topic_pages()) text += "\n" + to_markdown(page, 2);
  text += "\n" + to_markdown(page_of(root), 2);
  for (const CLI::App* command : visible_commands(root)) text += "\n" + to_markdown(page_of(*command), 2);
  return text;
}

std::map<std::string, std::string> manual_pages(const CLI::App& root) {
  std::map<std::string, std::string> pages{{"ardent.1", to_manual(page_of(root), 1, version())}};
  for (const CLI::App* command : visible_commands(root))
    pages[fmt::format("ardent-{}.1", command->get_name())] = to_manual(page_of(*command), 1, version());
  for (const Page& page : topic_pages()) pages[fmt::format("ardent-{}.5", page.name)] = to_manual(page, 5, version());
  return pages;
}

std::string bash_completion(const CLI::App& root) {
  std::string options, values;
  for (const CLI::App* command : visible_commands(root)) {
    std::vector<std::string> names;
    for (const OptionHelp& help : options_of(*command)) {
      names.insert(names.end(), help.names.begin(), help.names.end());
      for (const std::string& name : help.names)
        if (!help.words.empty())
          values += fmt::format("    {}:{}) COMPREPLY=($(compgen -W '{}' -- \"$word\")); return ;;\n",
                                command->get_name(), name, fmt::join(help.words, " "));
    }
    options += fmt::format("    {}) options='{}' ;;\n", command->get_name(), fmt::join(names, " "));
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
                     fmt::join(command_names(root), " "), values, fmt::join(help_topics(root), " "), options);
}

std::string zsh_completion(const CLI::App& root) {
  std::string commands, cases;
  for (const CLI::App* command : visible_commands(root)) {
    commands += fmt::format("    {}\n", quoted(command->get_name() + ":" + command->get_description()));
    cases += fmt::format("      {})\n        _arguments{} ;;\n", command->get_name(),
                         zsh_arguments(*command, help_topics(root)));
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
