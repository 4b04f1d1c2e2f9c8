#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/page/run_results.hpp"
#include "apps/text/csv_table.hpp"
#include "apps/text/svg_plot.hpp"

// Figures of a run, each described once: on its page, as a file, and its numbers beside that.

namespace apps {

/// One panel, wide, to be zoomed.
[[nodiscard]] PlotFigure chart(std::string name, std::string caption, PlotPanel panel);
/// One panel of half the width, likewise.
[[nodiscard]] PlotFigure cloud(std::string name, std::string caption, PlotPanel panel);
/// One panel as it is, with names at its ticks.
[[nodiscard]] PlotFigure drawing(std::string name, std::string caption, PlotPanel panel);

/// A dozen periods of a length in seconds around a time, where times go far beyond them; none: all of it.
[[nodiscard]] std::optional<std::pair<double, double>> some_periods(double period_s, const Eigen::VectorXd& time_s,
                                                                    double around_s);

/// Below the first panel of a free run, measured beside predicted: what is between them, on a scale of its own.
void add_error_panel(PlotFigure& figure);

/// Limits of an axis between which all of the values are but for one in a thousand, where the others lie far beyond
/// them; none: all of it, as always of fewer than two thousand.
[[nodiscard]] std::optional<std::pair<double, double>> limits_of_most(const Eigen::VectorXd& values);

/// Takes figures one by one, as they hold every sample.
using FigureTaker = std::function<void(PlotFigure)>;

/// Of a range and its chosen equation: measured against identified target, free run over x on data not fitted, residual
/// in time, in its spectrum and against each signal, phase portrait, restoring force against x and against v, evidence
/// by move. What does not exist is left out; nothing for a range without an equation.
void range_figures(const ident::RangeResult& range, const RunResults& results, const FigureTaker& take);

/// Of recordings that were kept: x and the chosen equation's free run.
void prediction_figures(const std::vector<ident::RecordPrediction>& predictions, const FigureTaker& take);

/// Of the recordings: x with its regimes and what is left out, response at the steps of a stepped sine, front-end
/// filter, spectra before and behind it.
void record_figures(const RunResults& results, const FigureTaker& take);

/// What figures of a range, by its number from 0, are called to begin with.
[[nodiscard]] std::string range_prefix(std::size_t range);

/// The first panel of a figure as numbers, figures/NAME.csv: one column for x and one for each series where these share
/// their x, else a row `series,x,y` for each point. Cells that do not exist are empty. The figure must outlive it.
[[nodiscard]] CsvTable figure_table(const PlotFigure& figure);

/// figures/NAME.svg and figures/NAME.csv.
using FileWriter = std::function<void(const std::string& name, std::string_view bytes)>;
void write_figure_files(const PlotFigure& figure, const FileWriter& write);

}  // namespace apps
