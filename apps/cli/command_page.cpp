#include "apps/cli/command_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <sstream>

#include "apps/reference/topics.hpp"

namespace apps {
namespace {

bool is_repeated(const Option& option) {
  return std::holds_alternative<std::vector<std::string>*>(option.target) ||
         std::holds_alternative<std::vector<std::filesystem::path>*>(option.target);
}

HelpEntry entry_of(const Option& option) {
  std::string term = fmt::format("{}", fmt::join(names_of(option), ", "));
  if (const std::string value = value_name(option); !value.empty()) term += (term.empty() ? "" : " ") + value;
  const OptionValue& value = option.value;
  std::string facts = value.words.empty() ? "" : fmt::format("One of {}.", fmt::join(value.words, ", "));
  if (!value.preset.empty()) facts += fmt::format("{}Left out: {}.", facts.empty() ? "" : " ", value.preset);
  return {term, option.help, facts};
}

std::string usage_of(const Command& command) {
  std::string arguments, options;
  for (const Option& option : command.options) {
    const std::string value = value_name(option);
    if (!names_of(option).empty()) {
      if (option.value.required) options += fmt::format(" {} {}", names_of(option).back(), value);
      continue;
    }
    const char* const dots = is_repeated(option) ? "..." : "";
    arguments += option.value.required ? fmt::format(" {}{}", value, dots) : fmt::format(" [{}{}]", value, dots);
  }
  return fmt::format("ardent {}{}{} [options]", command.name, arguments, options);
}

}  // namespace

std::vector<std::string> names_of(const Option& option) {
  std::vector<std::string> names;
  if (option.names.starts_with('-')) {
    std::istringstream list(option.names);
    for (std::string name; std::getline(list, name, ',');) names.push_back(name);
  }
  return names;
}

std::string value_name(const Option& option) {
  if (!option.names.starts_with('-')) return option.names;
  const Target& target = option.target;
  if (std::holds_alternative<std::monostate>(target) || std::holds_alternative<bool*>(target)) return "";
  if (!option.value.name.empty()) return option.value.name;
  const bool is_number = std::holds_alternative<int*>(target) || std::holds_alternative<std::uint64_t*>(target) ||
                         std::holds_alternative<std::optional<double>*>(target);
  return is_number ? "NUMBER" : "TEXT";
}

std::vector<const Command*> visible_commands(const Program& program) {
  std::vector<const Command*> visible;
  for (const Command& command : program.commands)
    if (!command.group.empty()) visible.push_back(&command);
  return visible;
}

Page page_of(const Program& program) {
  Page page{"ardent",
            "From raw vibration recordings to an equation of motion with error bars",
            "ardent COMMAND [options]",
            {}};
  for (const Command* command : visible_commands(program)) {
    if (page.sections.empty() || page.sections.back().heading != command->group)
      page.sections.push_back({command->group, "", {}, {}});
    page.sections.back().entries.push_back({command->name, command->help + ".", ""});
  }
  page.sections.push_back({"First steps",
                           "",
                           {},
                           {"ardent info drive.wav              # what the file is",
                            "ardent check drive.wav             # is it usable? what was assumed?",
                            "ardent run drive.wav -o drive-run  # its equation of motion",
                            "ardent help run                    # the same as ardent run --help",
                            "ardent help                        # what else is explained"}});
  Section options{"Options of most commands", "--help of a command lists those that it takes.", {}, {}};
  for (const Option& option : program.options) options.entries.push_back(entry_of(option));
  page.sections.push_back(std::move(options));
  page.sections.push_back({"Exit codes", exit_codes_page().sections.front().text, {}, {}});
  return page;
}

Page page_of(const Command& command) {
  Page page{command.name, command.help, usage_of(command), {}};
  if (!command.details.empty()) page.sections.push_back({"", command.details, {}, {}});
  Section arguments{"Arguments", "", {}, {}}, named{"Options", "", {}, {}};
  for (const Option& option : command.options)
    (names_of(option).empty() ? arguments : named).entries.push_back(entry_of(option));
  if (!arguments.entries.empty()) page.sections.push_back(std::move(arguments));
  page.sections.push_back(std::move(named));
  if (!command.more.empty()) page.sections.push_back({"More", "", {}, command.more});
  if (!command.examples.empty()) page.sections.push_back({"Examples", "", {}, command.examples});
  return page;
}

}  // namespace apps
