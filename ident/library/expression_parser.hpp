#pragma once
#include <functional>
#include <string_view>
#include <vector>

#include "ident/library/expression_tree.hpp"

namespace ident {

/// The tree of a text; any name that is_signal knows is a signal. Throws dsp::Fault (usage) "term.syntax",
/// "term.unknown_name", "term.assignment" or "term.too_long" with the position, counted from 1, what was found and what
/// is wanted; `known` ends the sentence on an unknown name.
[[nodiscard]] Tree parse_expression(std::string_view text, const std::function<bool(std::string_view)>& is_signal,
                                    const std::string& known);

}  // namespace ident
