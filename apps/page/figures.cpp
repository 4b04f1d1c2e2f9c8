#include "apps/page/figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/output/tables.hpp"
#include "dsp/values/order_statistics.hpp"

namespace apps {

using Eigen::Index;
using Eigen::VectorXd;

PlotFigure chart(std::string name, std::string caption, PlotPanel panel) {
  return {.panels = {std::move(panel)},
          .columns = 1,
          .panel_width_px = 900.0,
          .panel_height_px = 320.0,
          .caption = {std::move(caption)},
          .name = std::move(name),
          .zoomable = true};
}

PlotFigure cloud(std::string name, std::string caption, PlotPanel panel) {
  PlotFigure figure = drawing(std::move(name), std::move(caption), std::move(panel));
  figure.zoomable = true;
  return figure;
}

PlotFigure drawing(std::string name, std::string caption, PlotPanel panel) {
  return {.panels = {std::move(panel)},
          .columns = 1,
          .panel_height_px = 340.0,
          .caption = {std::move(caption)},
          .name = std::move(name)};
}

std::optional<std::pair<double, double>> some_periods(double period_s, const VectorXd& time_s, double around_s) {
  constexpr double shown = 12.0, most_of_all = 0.4;
  const double length = shown * period_s, first = time_s(0), last = time_s(time_s.size() - 1);
  if (!(length > 0.0) || length > most_of_all * (last - first)) return {};
  const double from = std::clamp(around_s - 0.5 * length, first, last - length);
  return std::pair{from, from + length};
}

std::optional<std::pair<double, double>> limits_of_most(const VectorXd& values) {
  constexpr double outside = 0.0005, far = 4.0;  // of the values, on either side; of the spread of the others
  std::vector<double> finite;
  finite.reserve(static_cast<std::size_t>(values.size()));
  for (const double value : values)
    if (std::isfinite(value)) finite.push_back(value);
  if (outside * static_cast<double>(finite.size()) < 1.0) return {};
  const auto [least_at, most_at] = std::minmax_element(finite.begin(), finite.end());
  const double least = *least_at, most = *most_at;
  const double low = dsp::quantile_in_place(finite, outside), high = dsp::quantile_in_place(finite, 1.0 - outside),
               spread = high - low;
  if (!(spread > 0.0) || most - least < far * spread) return {};
  return std::pair{low - 0.5 * spread, high + 0.5 * spread};
}

void add_error_panel(PlotFigure& figure) {
  const PlotPanel& run = figure.panels.front();
  const PlotSeries &measured = run.series[0], &predicted = run.series[1];
  const VectorXd error = measured.y - predicted.y;
  PlotPanel below{"error of the free run", run.x_label, run.y_label};
  below.series = {{"measured less free run", measured.x, error, PlotStyle::line, PlotColour::blue, true}};
  below.x_limits = run.x_limits;
  below.y_limits = limits_of_most(error);
  figure.panels.push_back(std::move(below));
}

std::string range_prefix(std::size_t range) {
  return fmt::format("range-{}-", range + 1);
}

CsvTable figure_table(const PlotFigure& figure) {
  const PlotPanel& panel = figure.panels.front();
  const std::vector<PlotSeries>& all = panel.series;
  std::vector<std::string> labels;
  std::vector<std::size_t> firsts;  // row of each series, where they are below one another
  CsvTable table{.name = fmt::format("figures/{}.csv", figure.name), .header = text_cell(panel.x_label)};
  for (const PlotSeries& series : all) {
    labels.push_back(text_cell(series.label.empty() ? panel.y_label : series.label));
    firsts.push_back(table.num_rows);
    table.num_rows += static_cast<std::size_t>(series.x.size());
  }
  const bool share_x = std::all_of(all.begin(), all.end(), [&](const PlotSeries& one) {
    return one.x.size() == all.front().x.size() && one.x == all.front().x;
  });
  if (share_x) {
    for (const std::string& label : labels) table.header += "," + label;
    table.num_rows = all.empty() ? 0 : static_cast<std::size_t>(all.front().x.size());
    table.fill = [&all](std::size_t row, RowWriter& cells) {
      cells.number_if_any(all.front().x(static_cast<Index>(row)));
      for (const PlotSeries& series : all) cells.number_if_any(series.y(static_cast<Index>(row)));
    };
  } else {
    table.header = fmt::format("series,{},{}", table.header, text_cell(panel.y_label));
    table.fill = [&all, labels, firsts](std::size_t row, RowWriter& cells) {
      const auto of =
          static_cast<std::size_t>(std::upper_bound(firsts.begin(), firsts.end(), row) - firsts.begin()) - 1;
      const auto i = static_cast<Index>(row - firsts[of]);
      cells.text(labels[of]);
      cells.number_if_any(all[of].x(i));
      cells.number_if_any(all[of].y(i));
    };
  }
  table.header += "\n";
  return table;
}

void write_figure_files(const PlotFigure& figure, const FileWriter& write) {
  write(fmt::format("figures/{}.svg", figure.name), to_svg(figure));
  const CsvTable table = figure_table(figure);
  std::string numbers;
  write_table(table, [&](std::string_view rows) { numbers += rows; });
  write(table.name, numbers);
}

}  // namespace apps
