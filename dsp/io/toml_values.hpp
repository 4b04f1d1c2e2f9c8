#pragma once
#include <map>
#include <string>
#include <string_view>

namespace dsp {

/// Every value of a TOML document by its path, "range.0.to", written as in TOML; arrays of plain values are one value.
/// `name` is used for the file in messages. Throws Fault (usage, "config.syntax").
[[nodiscard]] std::map<std::string, std::string> toml_values(std::string_view text, const std::string& name);

}  // namespace dsp
