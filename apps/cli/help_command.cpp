#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "apps/cli/command.hpp"
#include "apps/cli/command_page.hpp"
#include "apps/cli/reference_pages.hpp"
#include "apps/reference/guides.hpp"
#include "apps/reference/topics.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/names.hpp"

namespace apps {
namespace {

/// The entries of topics whose name this is: `ardent help cutoff_hz`.
std::string entries_called(const std::string& name) {
  std::string text;
  for (const Page& page : topic_pages())
    for (const Section& section : page.sections)
      for (const HelpEntry& entry : section.entries)
        if (entry.term == name) text += to_text({page.name, section.heading, "", {{"", "", {entry}, {}}}});
  return text;
}

std::string overview(const Program& program) {
  Page page{"help", "What `ardent help TOPIC` explains", "ardent help [TOPIC]", {{"Topics", "", {}, {}}}};
  for (const Page& topic : topic_pages()) page.sections[0].entries.push_back({topic.name, topic.summary + "."});
  for (const Guide& guide : guides)
    page.sections[0].entries.push_back({std::string(guide.name), std::string(guide.summary) + "."});
  page.sections[0].entries.push_back({"reference", "All of it, and every command, as one document in Markdown."});
  page.sections[0].entries.push_back({"KEY", "A key of a config or sidecar: ardent help cutoff_hz."});
  page.sections.push_back({"Commands", "", {}, {}});
  for (const Command* command : visible_commands(program))
    page.sections[1].entries.push_back({command->name, command->help + "."});
  return to_text(page);
}

std::string help_on(const Program& program, const std::string& topic) {
  if (topic.empty()) return overview(program);
  if (topic == "reference") return reference_markdown(program);
  std::vector<std::string> known{"reference"};
  for (const Guide& guide : guides) {
    if (topic == guide.name) return std::string(guide.text());
    known.emplace_back(guide.name);
  }
  for (const Page& page : topic_pages()) {
    if (page.name == topic) return to_text(page);
    known.push_back(page.name);
  }
  for (const Command* command : visible_commands(program)) {
    if (command->name == topic) return to_text(page_of(*command));
    known.push_back(command->name);
  }
  if (std::string entries = entries_called(topic); !entries.empty()) return entries;
  for (const Page& page : topic_pages())
    for (const Section& section : page.sections)
      for (const HelpEntry& entry : section.entries) known.push_back(entry.term);
  const auto begins =
      std::find_if(known.begin(), known.end(), [&](const std::string& name) { return name.starts_with(topic); });
  const std::string near = begins != known.end() ? *begins : dsp::nearest(topic, known);
  throw dsp::Fault(
      dsp::FaultKind::usage, "usage",
      fmt::format("help: there is no topic, command or key '{}'. {}", dsp::clean_name(topic),
                  near.empty() ? "ardent help lists the topics" : fmt::format("Did you mean '{}'?", near)));
}

}  // namespace

Command help_command() {
  const auto topic = std::make_shared<std::string>();
  return {.name = "help",
          .help = "Explains a command, a topic or a key",
          .group = help_group,
          .unused = {{"--output"}, {"--seed"}, {"--dry-run"}, {"--set"}, {"--force"}, {"--threads"}},
          .options = {{"TOPIC", topic.get(),
                       "config, sidecar, terms, methods, verdict, files, exit-codes, tutorial, method, validation, a "
                       "command, or a key."}},
          .run =
              [topic](const GlobalOptions&, Console& console) {
                console.result(help_on(make_program(), *topic));
                return 0;
              },
          .examples = {"ardent help config", "ardent help cutoff_hz"}};
}

}  // namespace apps
