#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/output/steps_table.hpp"
#include "apps/output/svg_plot.hpp"
#include "apps/output/tables.hpp"
#include "apps/page/run_results.hpp"

namespace apps {

/// A picture of a run: drawn on the page, and a file of its own beside its numbers.
struct RunFigure {
  std::string name;     ///< of the files, without ending: plain, of this run once
  std::string caption;  ///< sentences that say what to see
  PlotPanel panel;
  bool zoomable = true;   ///< lines over an ascending x
  std::string hint = {};  ///< one more sentence of the caption, for who can zoom
};

/// Numbers gathered one by one, as a series takes them.
[[nodiscard]] Eigen::VectorXd as_vector(const std::vector<double>& values);

/// Takes figures one by one, as they hold every sample.
using FigureTaker = std::function<void(RunFigure)>;

/// Of a range and its chosen equation: measured against identified target, free run over x on data not fitted, residual
/// in time, in its spectrum and against each signal, phase portrait, restoring force against x and against v, evidence
/// by move. What does not exist is left out; nothing for a range without an equation.
void range_figures(const ident::RangeResult& range, const RunResults& results, const FigureTaker& take);

/// Of recordings that were kept: x and the chosen equation's free run.
void prediction_figures(const RunResults& results, const FigureTaker& take);

/// Of the recordings: x with its regimes and what is left out, response at the steps of a stepped sine, front-end
/// filter, spectra before and behind it.
void record_figures(const RunResults& results, const std::vector<RecordingSteps>& steps, const FigureTaker& take);

/// The figure with at most so many points a series where these are lines over an ascending x: min_max_decimated.
[[nodiscard]] RunFigure decimated(RunFigure figure, Eigen::Index most_points);

/// The figure as a file.
[[nodiscard]] std::string figure_svg(const RunFigure& figure);
/// Its numbers, all of them: one column for x and one for each series where these share their x, else a row
/// `series,x,y` for each point. Cells that do not exist are empty.
void write_figure_numbers(const RunFigure& figure, const Sink& sink);
/// Both, as figures/NAME.svg and figures/NAME.csv.
using FileWriter = std::function<void(const std::string& name, std::string_view bytes)>;
void write_figure_files(const RunFigure& figure, const FileWriter& write);

}  // namespace apps
