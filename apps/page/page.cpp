#include "apps/page/page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "apps/page/chart_data.hpp"
#include "apps/page/document.hpp"
#include "apps/page/page_sections.hpp"
#include "apps/process/printable.hpp"

namespace apps {
namespace {

void write_first_screen(const FirstScreen& screen, HtmlWriter& html) {
  html.open("dl", {{"class", "first"}});
  for (const FirstScreen::Entry& entry : screen.entries) {
    html.element("dt", entry.label.empty() ? "note" : entry.label).open("dd");
    std::string to_paste;
    const auto paste = [&] {
      if (!to_paste.empty()) html.element("pre", to_paste);
      to_paste.clear();
    };
    for (const FirstScreen::Line& line : entry.lines) {
      if (line.to_paste) {
        to_paste += line.text + "\n";
        continue;
      }
      paste();
      html.element("p", line.text);
    }
    paste();
    html.close();
  }
  html.close();
}

/// Indices of the ranges, that of the chosen equation before the others.
std::vector<std::size_t> chosen_first(const RunResults& results) {
  std::vector<std::size_t> order(results.ranges.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const ident::RangeResult* chosen = chosen_equation(results.ranges).range;
  std::stable_partition(order.begin(), order.end(), [&](std::size_t i) { return &results.ranges[i] == chosen; });
  return order;
}

std::vector<PageLink> contents_of(const RunResults& results) {
  std::vector<PageLink> links;
  for (const std::size_t i : chosen_first(results))
    links.push_back({fmt::format("range-{}", i + 1), "Range " + printable(results.ranges[i].spec.name, 60)});
  if (!results.predictions.empty()) links.push_back({"others", "Other recordings"});
  links.insert(links.end(), {{"record", "The record"},
                             {"front-end", "Front end"},
                             {"repeat", "How to repeat it"},
                             {"words", "Words on this page"}});
  return links;
}

/// Points a series may have: what all of them take together, two bytes each, stays below 3 MB.
Eigen::Index most_points(const PageContent& content) {
  constexpr Eigen::Index all = 1'100'000, longest = most_points_of_a_page, shortest = 2'000;
  Eigen::Index wanted = 0;
  const auto count = [&](const std::vector<RunFigure>& figures) {
    for (const RunFigure& figure : figures)
      for (const PlotSeries& series : figure.panel.series)
        if (figure.zoomable) wanted += std::min(series.y.size(), longest);
  };
  for (const auto& figures : content.range_figures) count(figures);
  count(content.prediction_figures);
  count(content.record_figures);
  return wanted <= all ? longest : std::max(shortest, longest * all / wanted);
}

}  // namespace

void write_figure(const RunFigure& figure, Eigen::Index most_points, HtmlWriter& html) {
  const std::string id = "figure-" + figure.name;
  html.open("figure", {{"class", figure.zoomable ? "chart" : "cloud"}, {"aria-labelledby", id}});
  if (figure.zoomable) {
    html.element("h3", figure.panel.title);
    html.open("div", {{"class", "plot"}, {"role", "img"}, {"aria-labelledby", id}}).close();
    html.open("div", {{"class", "tools"}}).close();
    html.open("script", {{"type", "application/json"}})
        .markup(json_for_script(chart_json(figure.panel, most_points)))
        .close();
  } else {
    PlotFigure drawn;
    drawn.panels = {figure.panel};
    drawn.panel_height_px = 340.0;
    drawn.id = figure.name + "-";
    html.open("div", {{"role", "img"}, {"aria-labelledby", id}}).markup(to_svg(drawn)).close();
  }
  html.open("figcaption", {{"id", id}}).text(figure.caption + figure.hint).close();
  std::vector<std::vector<std::string>> rows;
  for (const PlotSeries& series : figure.panel.series) {
    double least = std::nan(""), greatest = least, squares = 0.0, count = 0.0;
    for (const double value : series.y)
      if (std::isfinite(value)) {
        least = std::fmin(least, value), greatest = std::fmax(greatest, value);
        squares += value * value, count += 1.0;
      }
    rows.push_back({series.label.empty() ? figure.panel.y_label : printable(series.label), fmt::format("{}", count),
                    fmt::format("{:.4g}", least), fmt::format("{:.4g}", greatest),
                    fmt::format("{:.4g}", std::sqrt(squares / count))});
  }
  html.open("details").element("summary", "In numbers");
  html.table(fmt::format("{}: {}", figure.panel.title, figure.panel.y_label),
             {"series", "points", "least", "greatest", "rms"}, rows);
  html.element("p", fmt::format("All points: figures/{}.csv; as a drawing: figures/{}.svg", figure.name, figure.name));
  html.close().close();
}

std::string report_page(const RunResults& results, const PageContent& content) {
  std::vector<std::string> names;
  for (const Input& input : results.inputs) names.push_back(printable(input.prepared.name, 200));
  constexpr std::size_t most_names = 4;
  if (names.size() > most_names) names.resize(most_names), names.emplace_back("...");
  const std::string title = fmt::format("Equation of motion from {}", fmt::join(names, ", "));
  return html_document(title, [&](HtmlWriter& html) {
    write_first_screen(content.first, html);
    write_contents(contents_of(results), html);
    const Eigen::Index most = most_points(content);
    for (const std::size_t i : chosen_first(results))
      write_range(results.ranges[i], results, content.range_figures[i], most, html);
    write_agreement(results, html);
    write_predictions(results, content.prediction_figures, most, html);
    write_record(results, content.record_figures, most, html);
    write_front_end(results, content.record_figures, most, html);
    write_repeat(results, content.config, html);
    write_words(html);
  });
}

}  // namespace apps
