#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "apps/reference/page.hpp"

// What the parser knows of the command line, for `--help`, manual pages, the reference and completion.

namespace apps {

/// An option or argument of a command.
struct OptionHelp {
  std::vector<std::string> names;  ///< "-o", "--output"; empty: an argument
  std::string value;               ///< "DIR", of an argument its name; empty: a flag
  std::vector<std::string> words;  ///< not empty: the value is one of these
  std::string meaning, preset;
  bool required = false, repeated = false;
};
/// Arguments first, --help last; nothing that is hidden.
[[nodiscard]] std::vector<OptionHelp> options_of(const CLI::App& command);

/// The commands a person may type, in groups.
[[nodiscard]] std::vector<const CLI::App*> visible_commands(const CLI::App& root);

/// Of `ardent` itself or one of its commands.
[[nodiscard]] Page page_of(const CLI::App& app);

/// A sentence on what was typed wrongly: the nearest command or option, or what is missing.
[[nodiscard]] std::string usage_message(const CLI::App& root, const CLI::ParseError& error);

}  // namespace apps
