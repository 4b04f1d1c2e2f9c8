#pragma once
#include <string>
#include <vector>

#include "apps/config/study_cells.hpp"
#include "apps/text/svg_plot.hpp"

namespace apps {

/// Every cell as a line for each range and method, then the best cut-off where it was varied, then what persists: how
/// often each term is kept and between which coefficients.
[[nodiscard]] std::string study_text(const std::vector<StudyResult>& results, const std::vector<StudyAxis>& axes);
/// setting, range, method, num_terms, nmse_train, nmse_test, nmse_free_run, terms.
[[nodiscard]] std::string study_csv(const std::vector<StudyResult>& results);
/// {"axes": [{key, values}], "cells": [{setting, range, method, status, tau, num_train, num_test, nmse, terms}],
/// "best_cutoff": setting of a cell or null}.
[[nodiscard]] std::string study_json(const std::vector<StudyResult>& results, const std::vector<StudyAxis>& axes);
/// One range, number `range` of every cell: for each axis the NMSE of train, test and free run, and which terms are
/// kept.
[[nodiscard]] PlotFigure study_figure(const std::vector<StudyResult>& results, const std::vector<StudyAxis>& axes,
                                      std::size_t range);

}  // namespace apps
