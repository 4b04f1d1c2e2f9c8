#pragma once
#include <string>
#include <vector>

#include "apps/output/run_comparison.hpp"
#include "apps/page/figures.hpp"

namespace apps {

/// Each coefficient of each range: its value in every run with its 95 % interval, and the true value where it is known.
/// Nothing of a term that only one run has, or of more runs than a figure can show.
[[nodiscard]] std::vector<PlotFigure> comparison_figures(const RunComparison& comparison);

/// compare.html: what differs between runs, then range by range verdicts, coefficients and errors side by side, with
/// these figures. As self-contained as report.html.
[[nodiscard]] std::string comparison_page(const RunComparison& comparison, const std::vector<PlotFigure>& figures);

}  // namespace apps
