#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace apps {

enum class PlotStyle { line, dashed, points };

/// Colours that stay apart for colour-blind readers (Okabe and Ito) and in grey print.
enum class PlotColour { black, vermilion, blue, green, orange, purple, sky };

/// Points in order; a value that is not finite interrupts the line.
struct PlotSeries {
  std::string label;  ///< in the legend; empty: not there
  Eigen::VectorXd x, y;
  PlotStyle style = PlotStyle::line;
  PlotColour colour = PlotColour::black;
  bool band_limited = false;  ///< samples of what has no more than their band: between them it is known
};

/// Of numbers that were gathered one by one.
[[nodiscard]] PlotSeries plot_series(std::string label, const std::vector<double>& x, const std::vector<double>& y,
                                     PlotStyle style, PlotColour colour);

/// An interval of x that is shaded over the whole height, with its name at the top where there is room.
struct PlotSpan {
  double from = 0.0, to = 0.0;
  std::string label;
  PlotColour colour = PlotColour::sky;
};

/// One pair of axes. Limits left out are those of the data, with a small margin.
struct PlotPanel {
  std::string title, x_label, y_label;  ///< with units: "displacement x (m)"
  std::vector<PlotSeries> series = {};
  std::optional<std::pair<double, double>> x_limits = {}, y_limits = {};
  std::vector<std::string> x_names = {}, y_names = {};  ///< of 0, 1, 2 ... in place of numbers at the ticks
  std::vector<PlotSpan> spans = {};
  bool x_log = false;  ///< x by its logarithm: every x, and given limits, above zero; without names
};

/// What a reader asks of a page, in the order of asking. Where it has several figures to show, the first is shown
/// first.
enum class Question { none, follows, left_over, coefficients, choice };

/// A figure as it is described once: to_svg draws it as a file, a page as a chart where it is zoomable.
struct PlotFigure {
  std::string title;
  std::vector<PlotPanel> panels;  ///< row by row
  int columns = 2;
  double panel_width_px = 460.0, panel_height_px = 300.0;
  std::vector<std::string> caption;  ///< paragraphs that say what to see
  std::string name = "p";            ///< of its files, without ending; plain, of one page once
  bool zoomable = false;             ///< no axis has names; panels below one another share their x
  Question question = Question::none;
};

/// The figure as an SVG document of its own: no script, no link, no font but the reader's sans-serif; its caption under
/// the panels, wrapped to their width. Lines are thinned without loss to the eye: those over an ascending x to their
/// envelope in pixel columns, and to points a third of a pixel apart. Coordinates have two decimals; the same figure
/// gives the same bytes.
[[nodiscard]] std::string to_svg(const PlotFigure& figure);

/// Where ticks go between low and high: multiples of 1, 2 or 5 times a power of ten, `most` at most.
[[nodiscard]] std::vector<double> nice_ticks(double low, double high, int most);
/// The same of 0 < low < high on a logarithmic axis: 1, 2 and 5 times the powers of ten, or these alone; `nice_ticks`
/// where low and high are so near that fewer than two of them lie between.
[[nodiscard]] std::vector<double> log_ticks(double low, double high, int most);

}  // namespace apps
