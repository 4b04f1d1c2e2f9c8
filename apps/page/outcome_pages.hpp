#pragma once
#include <string>
#include <vector>

#include "apps/config/study_cells.hpp"
#include "apps/output/equation_response.hpp"

// Pages of what is made of runs, from the parts of a run's own page.

namespace apps {

/// frc.html: both curves of an equation's response, to be zoomed, and the words of the terminal.
[[nodiscard]] std::string response_page(const EquationResponse& result);

/// study.html: the figure of each range, and the words of the terminal.
[[nodiscard]] std::string study_page(const std::vector<StudyResult>& results, const std::vector<StudyAxis>& axes,
                                     const std::vector<std::string>& ranges);

}  // namespace apps
