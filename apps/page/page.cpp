#include "apps/page/page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "apps/output/report_text.hpp"
#include "apps/page/chart_data.hpp"
#include "apps/page/document.hpp"
#include "apps/page/page_sections.hpp"
#include "apps/page/screen_html.hpp"
#include "apps/process/printable.hpp"

namespace apps {
namespace {

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

}  // namespace

void write_screen(const FirstScreen& screen, HtmlWriter& html) {
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

PageFigure page_figure(const PlotFigure& figure, bool has_files) {
  HtmlWriter html;
  const std::string id = "figure-" + figure.name;
  const PlotPanel& panel = figure.panels.front();
  html.open("figure", {{"class", figure.zoomable ? "chart" : "cloud"}, {"aria-labelledby", id}});
  if (figure.zoomable) {
    html.element("h3", panel.title);
    html.open("div", {{"class", "plot"}, {"role", "img"}, {"aria-labelledby", id}}).close();
    html.open("div", {{"class", "tools"}}).close();
    html.open("script", {{"type", "application/json"}}).markup(json_for_script(chart_json(panel))).close();
  } else {
    PlotFigure drawn = figure;
    drawn.caption.clear();
    html.open("div", {{"role", "img"}, {"aria-labelledby", id}}).markup(to_svg(drawn)).close();
  }
  const bool is_part = figure.zoomable && panel.x_limits;
  html.element("figcaption",
               fmt::format("{}{}", fmt::join(figure.caption, " "), is_part ? " The button 'all' shows the rest." : ""),
               {{"id", id}});
  std::vector<std::vector<std::string>> rows;
  for (const PlotSeries& series : panel.series) {
    double least = std::nan(""), greatest = least, squares = 0.0, count = 0.0;
    for (const double value : series.y)
      if (std::isfinite(value)) {
        least = std::fmin(least, value), greatest = std::fmax(greatest, value);
        squares += value * value, count += 1.0;
      }
    rows.push_back({series.label.empty() ? panel.y_label : printable(series.label), fmt::format("{}", count),
                    fmt::format("{:.4g}", least), fmt::format("{:.4g}", greatest),
                    fmt::format("{:.4g}", std::sqrt(squares / count))});
  }
  html.open("details").element("summary", "In numbers");
  html.table(fmt::format("{}: {}", panel.title, panel.y_label), {"series", "points", "least", "greatest", "rms"}, rows);
  if (has_files)
    html.element("p",
                 fmt::format("All points: figures/{}.csv; as a drawing: figures/{}.svg", figure.name, figure.name));
  html.close().close();
  return {figure.name, html.html(), figure.zoomable};
}

bool write_figures(const std::vector<PageFigure>& figures, std::string_view prefix, HtmlWriter& html) {
  bool any = false;
  for (const bool zoomable : {true, false}) {
    std::vector<const PageFigure*> own;
    for (const PageFigure& figure : figures)
      if (figure.zoomable == zoomable && figure.name.starts_with(prefix)) own.push_back(&figure);
    if (own.empty()) continue;
    html.open("div", {{"class", zoomable ? "charts" : "clouds"}});
    for (const PageFigure* figure : own) html.markup(figure->markup);
    html.close();
    any = true;
  }
  return any;
}

std::string report_page(const RunResults& results, const PageContent& content) {
  std::vector<std::string> names;
  for (const Input& input : results.inputs) names.push_back(printable(input.prepared.name, 200));
  constexpr std::size_t most_names = 4;
  if (names.size() > most_names) names.resize(most_names), names.emplace_back("...");
  const std::string title = fmt::format("Equation of motion from {}", fmt::join(names, ", "));
  return html_document(title, [&](HtmlWriter& html) {
    write_screen(content.first, html);
    write_contents(contents_of(results), html);
    for (const std::size_t i : chosen_first(results)) write_range(results.ranges[i], results, content.figures, html);
    write_agreement(results, html);
    write_predictions(results.predictions, content.figures, html);
    write_record(results, content.figures, html);
    write_front_end(results, content.figures, html);
    write_repeat(results.inputs.size(), content.config, html);
    write_words(html);
  });
}

std::string prediction_page(const ident::RecordPrediction& prediction, const std::string& equation) {
  std::vector<PageFigure> figures;
  prediction_figures({prediction}, [&](const PlotFigure& figure) { figures.push_back(page_figure(figure, false)); });
  return html_document(fmt::format("Prediction of {}", printable(prediction.recording, 200)), [&](HtmlWriter& html) {
    html.element("p", printable(equation)).element("p", coordinates_sentence({prediction.coordinates}));
    write_predictions({prediction}, figures, html);
  });
}

}  // namespace apps
