#include "apps/page/figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "apps/page/chart_data.hpp"

namespace apps {
namespace {

using Eigen::Index;

void append(std::string& line, double value) {
  if (!std::isfinite(value)) return;
  std::array<char, 32> text;
  line.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
}

bool share_x(const std::vector<PlotSeries>& series) {
  return std::all_of(series.begin(), series.end(), [&](const PlotSeries& one) {
    return one.x.size() == series.front().x.size() && one.x == series.front().x;
  });
}

std::string label_of(const PlotSeries& series, const PlotPanel& panel) {
  return text_cell(series.label.empty() ? panel.y_label : series.label);
}

void write_side_by_side(const PlotPanel& panel, const Sink& sink) {
  std::string line = text_cell(panel.x_label);
  for (const PlotSeries& series : panel.series) line.append(1, ',').append(label_of(series, panel));
  sink(line + "\n");
  for (Index i = 0; i < panel.series.front().x.size(); ++i) {
    line.clear();
    append(line, panel.series.front().x(i));
    for (const PlotSeries& series : panel.series) {
      line += ',';
      append(line, series.y(i));
    }
    line += '\n';
    sink(line);
  }
}

}  // namespace

Eigen::VectorXd as_vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values));
}

RunFigure decimated(RunFigure figure, Index most_points) {
  if (!figure.zoomable) return figure;
  for (PlotSeries& series : figure.panel.series) {
    Decimated few = min_max_decimated(series.x, series.y, most_points);
    series.x = std::move(few.x);
    series.y = std::move(few.y);
  }
  return figure;
}

std::string figure_svg(const RunFigure& figure) {
  PlotFigure file;
  file.panels = {figure.panel};
  file.columns = 1;
  file.panel_width_px = figure.zoomable ? 900.0 : 460.0;
  file.panel_height_px = figure.zoomable ? 320.0 : 340.0;
  file.caption = {figure.caption};
  file.id = figure.name + "-";
  return to_svg(file);
}

void write_figure_numbers(const RunFigure& figure, const Sink& sink) {
  const PlotPanel& panel = figure.panel;
  if (panel.series.empty()) return;
  if (share_x(panel.series)) return write_side_by_side(panel, sink);
  std::string line = fmt::format("series,{},{}\n", text_cell(panel.x_label), text_cell(panel.y_label));
  sink(line);
  for (const PlotSeries& series : panel.series)
    for (Index i = 0; i < series.x.size(); ++i) {
      line = label_of(series, panel) + ",";
      append(line, series.x(i));
      line += ',';
      append(line, series.y(i));
      line += '\n';
      sink(line);
    }
}

void write_figure_files(const RunFigure& figure, const FileWriter& write) {
  write("figures/" + figure.name + ".svg", figure_svg(figure));
  std::string numbers;
  write_figure_numbers(figure, [&](std::string_view text) { numbers += text; });
  write("figures/" + figure.name + ".csv", numbers);
}

}  // namespace apps
