#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace apps {

/// Absolute, links followed as far as it exists, no "." or ".." or "/" at its end. Never throws for what is on the
/// disk: what cannot be followed is taken as it is written.
[[nodiscard]] std::filesystem::path resolved_path(const std::filesystem::path& path);

/// The same file or folder by a name that has a last part: no "." or ".." or "/" at its end.
[[nodiscard]] std::filesystem::path named_path(const std::filesystem::path& path);

/// Absolute, links of folders followed, but called as it is named: where a person finds it. A file that is a link keeps
/// its own name.
[[nodiscard]] std::filesystem::path located_path(const std::filesystem::path& path);

/// The shortest ends of paths that tell them apart: "mon/run", "tue/run". One path twice has one name.
[[nodiscard]] std::vector<std::string> distinct_names(const std::vector<std::filesystem::path>& paths);

/// `inner` is `outer` or lies in it; both resolved.
[[nodiscard]] bool lies_in(const std::filesystem::path& inner, const std::filesystem::path& outer);

/// A relative path that stays where it is joined to: not empty, no "." or "..".
[[nodiscard]] bool is_plain(const std::filesystem::path& path);

}  // namespace apps
