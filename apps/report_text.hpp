#pragma once
#include <string>
#include <vector>

#include "apps/identify.hpp"

namespace apps {

/// The identified equations for a terminal: each with its error bars and, right under it, whether it is to be trusted;
/// then what the ranges disagree on.
[[nodiscard]] std::string report_text(const std::vector<RangeResult>& ranges);

/// The same equations as LaTeX, the judgement as a comment before each.
[[nodiscard]] std::string report_latex(const std::vector<RangeResult>& ranges);

}  // namespace apps
