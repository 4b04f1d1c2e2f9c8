#include "apps/page/figures.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/output/tables.hpp"

namespace apps {

using Eigen::Index;

PlotFigure chart(std::string name, std::string caption, PlotPanel panel) {
  return {.panels = {std::move(panel)},
          .columns = 1,
          .panel_width_px = 900.0,
          .panel_height_px = 320.0,
          .caption = {std::move(caption)},
          .name = std::move(name),
          .zoomable = true};
}

PlotFigure drawing(std::string name, std::string caption, PlotPanel panel) {
  return {.panels = {std::move(panel)},
          .columns = 1,
          .panel_height_px = 340.0,
          .caption = {std::move(caption)},
          .name = std::move(name)};
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
