#pragma once
#include <string>
#include <vector>

#include "apps/page/first_screen.hpp"
#include "apps/page/page_sections.hpp"
#include "apps/page/run_results.hpp"

namespace apps {

/// The first ones and that of the chosen equation: a run of a hundred recordings has as many ranges.
inline constexpr std::size_t most_ranges_with_figures = 12;

/// report.html: one file that asks for nothing else, neither from the folder nor from anywhere; the same bytes for the
/// same run.
[[nodiscard]] std::string report_page(const RunResults& results, const FirstScreen& first,
                                      const std::vector<PageFigure>& figures);

/// predict.html, likewise: an equation as text, warnings on the recording, and the equation run free on it beside what
/// was measured.
[[nodiscard]] std::string prediction_page(const ident::RecordPrediction& prediction, const std::string& equation,
                                          const std::vector<std::string>& warnings);

}  // namespace apps
