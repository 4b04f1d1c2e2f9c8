#pragma once
#include <toml++/toml.h>

#include <string>
#include <string_view>

namespace dsp {

/// Keys of one line: `a.b.c` has three. Tables within tables are taken apart by recursion, so their depth is limited;
/// ours reach four.
inline constexpr int most_key_parts = 16;

/// A TOML document; `name` is used for its file in messages. Throws Fault (usage) config.syntax, `name:line: ...`, also
/// for a key of more than most_key_parts.
[[nodiscard]] toml::table parse_toml(std::string_view text, const std::string& name);

}  // namespace dsp
