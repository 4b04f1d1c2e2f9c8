#pragma once
#include <string>
#include <vector>

#include "apps/cli/command.hpp"
#include "apps/reference/page.hpp"

// What the commands' data says to a reader: for `--help`, manual pages, the reference and completion.

namespace apps {

/// "-o", "--output"; none of an argument.
[[nodiscard]] std::vector<std::string> names_of(const Option& option);
/// "DIR", of an argument its name; empty: a flag.
[[nodiscard]] std::string value_name(const Option& option);

/// All but those that only the build needs.
[[nodiscard]] std::vector<const Command*> visible_commands(const Program& program);

/// Of `ardent` itself.
[[nodiscard]] Page page_of(const Program& program);
[[nodiscard]] Page page_of(const Command& command);

}  // namespace apps
