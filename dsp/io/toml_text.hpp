#pragma once
#include <toml++/toml.h>

#include <string>
#include <string_view>

namespace dsp {

// What a document may be, looked at before toml++ takes it apart: tables within tables go by recursion, and its
// bookkeeping of tables takes time that grows with the square of their number.

/// Keys of one line: `a.b.c` has three; ours reach four.
inline constexpr int most_key_parts = 16;
/// Arrays and inline tables within one another; ours reach two.
inline constexpr int most_brackets = 16;
/// Keys, tables and elements together, counted by their `=`, `[`, `{` and `,`. The largest recordings have 1024
/// channels, of which a sidecar says some twenty things each.
inline constexpr int most_entries = 30'000;
/// Far more than that many take; a comment may be long.
inline constexpr std::size_t most_toml_bytes = std::size_t{16} << 20;

/// A TOML document; `name` is used for its file in messages. Throws Fault (usage) config.syntax, `name:line: ...`, also
/// for one beyond the limits above.
[[nodiscard]] toml::table parse_toml(std::string_view text, const std::string& name);

}  // namespace dsp
