#pragma once
#include <CLI/CLI.hpp>
#include <map>
#include <string>

namespace apps {

/// docs/reference.md: every topic, then every command.
[[nodiscard]] std::string reference_markdown(const CLI::App& root);

/// Manual pages by file name: ardent.1, ardent-run.1, ..., ardent-config.5, ...
[[nodiscard]] std::map<std::string, std::string> manual_pages(const CLI::App& root);

/// What a shell reads to complete command lines.
[[nodiscard]] std::string bash_completion(const CLI::App& root);
[[nodiscard]] std::string zsh_completion(const CLI::App& root);

}  // namespace apps
