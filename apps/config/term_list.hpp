#pragma once
#include <string>
#include <vector>

namespace apps {

/// The terms of --terms: "1,x,x^2", commas outside brackets between them, or a file with one term a line (# begins a
/// comment). Throws dsp::Fault (usage): "term.syntax" for an empty one, "config.file" for no such file.
[[nodiscard]] std::vector<std::string> read_terms(const std::string& argument);

}  // namespace apps
