#pragma once
#include <map>
#include <string>

#include "apps/cli/command.hpp"

namespace apps {

/// docs/reference.md: every topic, then every command.
[[nodiscard]] std::string reference_markdown(const Program& program);

/// Manual pages by file name: ardent.1, ardent-run.1, ..., ardent-config.5, ...
[[nodiscard]] std::map<std::string, std::string> manual_pages(const Program& program);

/// What a shell reads to complete command lines.
[[nodiscard]] std::string bash_completion(const Program& program);
[[nodiscard]] std::string zsh_completion(const Program& program);

}  // namespace apps
