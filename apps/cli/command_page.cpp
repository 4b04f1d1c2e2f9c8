#include "apps/cli/command_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

#include "apps/cli/command.hpp"
#include "apps/reference/topics.hpp"
#include "dsp/names.hpp"

namespace apps {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// Words of a validator's description: "{one,two}".
std::vector<std::string> words_in(const std::string& type) {
  const std::size_t open = type.find('{'), close = type.find('}', open);
  std::vector<std::string> words;
  if (close == std::string::npos) return words;
  std::istringstream list(type.substr(open + 1, close - open - 1));
  for (std::string word; std::getline(list, word, ',');) words.push_back(word.substr(0, word.find("->")));
  return words;
}

std::string value_of(const CLI::Option& option) {
  if (option.get_positional()) return option.get_name(true);
  if (option.get_expected_max() == 0) return "";
  if (!option.get_option_text().empty()) return option.get_option_text();
  const std::string type = option.get_type_name(), kind = type.substr(0, type.find(':'));
  return kind == "FLOAT" || kind == "INT" || kind == "UINT" ? "NUMBER" : kind;
}

OptionHelp help_of(const CLI::Option& option) {
  OptionHelp help;
  if (!option.get_positional()) {
    for (const std::string& name : option.get_snames()) help.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) help.names.push_back("--" + name);
  }
  help.value = value_of(option);
  help.words = words_in(option.get_type_name());
  help.meaning = option.get_description();
  help.preset = option.get_expected_max() == 0 ? "" : option.get_default_str();
  help.required = option.get_required();
  help.repeated = option.get_items_expected_max() > 1;
  return help;
}

Entry entry_of(const OptionHelp& help) {
  std::string term = fmt::format("{}", fmt::join(help.names, ", "));
  if (!help.value.empty()) term += (term.empty() ? "" : " ") + help.value;
  std::string facts = help.words.empty() ? "" : fmt::format("One of {}.", fmt::join(help.words, ", "));
  if (!help.preset.empty()) facts += fmt::format("{}Left out: {}.", facts.empty() ? "" : " ", help.preset);
  return {term, help.meaning, facts};
}

Page root_page(const CLI::App& root) {
  Page page{"ardent", root.get_description(), "ardent COMMAND [options]", {}};
  for (const CLI::App* command : visible_commands(root)) {
    const std::string& group = command->get_group();
    if (page.sections.empty() || page.sections.back().heading != group) page.sections.push_back({group, "", {}, {}});
    page.sections.back().entries.push_back({command->get_name(), command->get_description() + ".", ""});
  }
  Section options{"Options of most commands", "--help of a command lists those that it takes.", {}, {}};
  for (const OptionHelp& help : options_of(root)) options.entries.push_back(entry_of(help));
  page.sections.push_back({"First steps",
                           "",
                           {},
                           {"ardent info drive.wav              # what the file is",
                            "ardent check drive.wav             # is it usable? what was assumed?",
                            "ardent run drive.wav -o drive-run  # its equation of motion",
                            "ardent help run                    # the same as ardent run --help",
                            "ardent help                        # what else is explained"}});
  page.sections.push_back(std::move(options));
  page.sections.push_back({"Exit codes", exit_codes_page().sections.front().text, {}, {}});
  return page;
}

const Command* find_command(const std::vector<Command>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Command& one) { return one.name == name; });
  return found == all.end() ? nullptr : &*found;
}

std::string usage_of(const CLI::App& app, const std::vector<OptionHelp>& options) {
  std::string usage = "ardent " + app.get_name();
  for (const OptionHelp& help : options) {
    const std::string value = help.value + (help.names.empty() && help.repeated ? "..." : "");
    if (help.names.empty()) usage += help.required ? " " + value : fmt::format(" [{}]", value);
    if (!help.names.empty() && help.required) usage += fmt::format(" {} {}", help.names.back(), help.value);
  }
  return usage + " [options]";
}

/// Options of all commands and of `ardent` itself, once each.
std::vector<std::string> all_option_names(const CLI::App& root) {
  std::vector<std::string> names;
  const auto add = [&](const CLI::App& app) {
    for (const OptionHelp& help : options_of(app))
      for (const std::string& name : help.names)
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const CLI::App* command : visible_commands(root)) add(*command);
  return names;
}

/// A word that looks like an option and is none of this command.
std::string unknown_option(const CLI::App& root, const CLI::App& command, const std::string& typed) {
  const std::string name = typed.substr(0, typed.find('='));
  std::vector<std::string> own;
  for (const OptionHelp& help : options_of(command)) own.insert(own.end(), help.names.begin(), help.names.end());
  const std::string near = dsp::nearest(name, own);
  std::string text = fmt::format("{}: there is no option {}", command.get_name(), dsp::clean_name(name));
  if (!near.empty()) return text + fmt::format(". Did you mean {}?", near);
  const std::vector<std::string> all = all_option_names(root);
  if (std::find(all.begin(), all.end(), name) != all.end()) text += " here; other commands have it";
  return text + fmt::format(". See ardent {} --help", command.get_name());
}

}  // namespace

std::vector<OptionHelp> options_of(const CLI::App& command) {
  std::vector<OptionHelp> arguments, options, help;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group().empty()) continue;
    auto& list = option->get_positional() ? arguments : option == command.get_help_ptr() ? help : options;
    list.push_back(help_of(*option));
  }
  for (OptionHelp& one : help) one.meaning = "Print this page.";
  arguments.insert(arguments.end(), options.begin(), options.end());
  arguments.insert(arguments.end(), help.begin(), help.end());
  return arguments;
}

std::vector<const CLI::App*> visible_commands(const CLI::App& root) {
  std::vector<const CLI::App*> visible;
  for (const CLI::App* command : root.get_subcommands([](const CLI::App*) { return true; }))
    if (!command->get_group().empty()) visible.push_back(command);
  return visible;
}

Page page_of(const CLI::App& app) {
  if (app.get_parent() == nullptr) return root_page(app);
  const std::vector<Command> all = commands();
  const Command* command = find_command(all, app.get_name());
  const std::vector<OptionHelp> options = options_of(app);
  Page page{app.get_name(), app.get_description(), usage_of(app, options), {}};
  if (command != nullptr && command->details[0] != '\0') page.sections.push_back({"", command->details, {}, {}});
  Section arguments{"Arguments", "", {}, {}}, named{"Options", "", {}, {}};
  for (const OptionHelp& help : options) (help.names.empty() ? arguments : named).entries.push_back(entry_of(help));
  if (!arguments.entries.empty()) page.sections.push_back(std::move(arguments));
  page.sections.push_back(std::move(named));
  if (!app.get_footer().empty()) page.sections.push_back({"More", "", {}, lines_of(app.get_footer())});
  if (command == nullptr || command->examples.empty()) return page;
  page.sections.push_back({"Examples", "", {}, {command->examples.begin(), command->examples.end()}});
  return page;
}

std::string usage_message(const CLI::App& root, const CLI::ParseError& error) {
  const std::vector<std::string> rest = root.remaining(true);
  const std::vector<CLI::App*> chosen = root.get_subcommands();
  if (chosen.empty()) {
    const auto typed = std::find_if(rest.begin(), rest.end(), [](const std::string& word) { return word[0] != '-'; });
    if (typed == rest.end() && !rest.empty())
      return fmt::format("there is no option {} before a command. See ardent --help", dsp::clean_name(rest.front()));
    if (typed == rest.end()) return "no command. ardent --help lists them; a first one: ardent info FILE";
    std::vector<std::string> names;
    for (const CLI::App* command : visible_commands(root)) names.push_back(command->get_name());
    const std::string near = dsp::nearest(*typed, names);
    return fmt::format("there is no command '{}'. {}", dsp::clean_name(*typed),
                       near.empty()
                           ? fmt::format("There are {}. For a recording: ardent run FILE", fmt::join(names, ", "))
                           : fmt::format("Did you mean ardent {}?", near));
  }
  const CLI::App& command = *chosen.front();
  for (const std::string& word : rest)
    if (word.size() > 1 && word[0] == '-') return unknown_option(root, command, word);
  if (!rest.empty())
    return fmt::format("{}: '{}' is one argument too many. See ardent {} --help", command.get_name(),
                       dsp::clean_name(rest.front()), command.get_name());
  std::string text = error.what();
  if (const std::size_t at = text.find(" not in {"); at != std::string::npos && text.ends_with('}'))
    text = fmt::format("{}, which is none of {}", text.substr(0, at), text.substr(at + 9, text.size() - at - 10));
  for (const OptionHelp& help : options_of(command))
    if (help.required && help.names.empty() && text.starts_with(help.value + " is required"))
      return fmt::format("{0}: {1} is missing. {1}: {2} See ardent {0} --help", command.get_name(), help.value,
                         help.meaning);
  return fmt::format("{}: {}. See ardent {} --help", command.get_name(), text, command.get_name());
}

}  // namespace apps
