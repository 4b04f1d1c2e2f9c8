#include "apps/page/page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "apps/output/report_text.hpp"
#include "apps/page/chart_data.hpp"
#include "apps/page/document.hpp"
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
  if (results.ranges.size() > 1) links.push_back({"agreement", "Do the ranges agree?"});
  if (!results.predictions.empty()) links.push_back({"others", "Other recordings"});
  links.insert(links.end(), {{"record", "The record"},
                             {"front-end", "Front end"},
                             {"repeat", "How to repeat it"},
                             {"words", "Words on this page"}});
  return links;
}

}  // namespace

namespace {

std::string sentences(const std::vector<std::string>& paragraphs) {
  std::string text;
  for (const std::string& one : paragraphs)
    text += fmt::format("{}{}{}", text.empty() ? "" : " ", one, one.ends_with('.') ? "" : ".");
  return text;
}

}  // namespace

PageFigure page_figure(const PlotFigure& figure, bool has_files) {
  HtmlWriter html;
  const std::string id = "figure-" + figure.name;
  const PlotPanel& panel = figure.panels.front();
  html.open("figure", {{"class", figure.zoomable ? "chart" : "drawing"}, {"aria-labelledby", id}});
  html.element("p", panel.title, {{"class", "title"}});
  if (figure.zoomable) {
    for (const PlotPanel& one : figure.panels)
      html.open("div", {{"class", "plot"}, {"role", "img"}, {"aria-labelledby", id}})
          .open("script", {{"type", "application/json"}})
          .markup(json_for_script(chart_json(one)))
          .close()
          .close();
  } else {
    PlotFigure drawn = figure;
    drawn.caption.clear();
    html.open("div", {{"role", "img"}, {"aria-labelledby", id}}).markup(to_svg(drawn)).close();
  }
  html.open("div", {{"class", "tools"}, {"data-name", figure.name}}).close();
  std::size_t num_beyond = 0;
  for (const PlotPanel& one : figure.panels)
    for (const PlotSeries& series : one.series)
      if (figure.zoomable && one.y_limits)
        num_beyond += static_cast<std::size_t>(
            (series.y.array() < one.y_limits->first || series.y.array() > one.y_limits->second).count());
  const bool is_part = figure.zoomable && (panel.x_limits || num_beyond > 0);
  html.open("figcaption", {{"id", id}}).text(sentences(figure.caption));
  if (num_beyond > 0) html.text(fmt::format(" {} points lie far beyond the axis.", num_beyond));
  if (is_part) html.element("span", " The button 'all' shows the rest.", {{"class", "screen"}});
  html.close();
  std::vector<std::vector<std::string>> rows;
  for (const PlotPanel& one : figure.panels)
    for (const PlotSeries& series : one.series) {
      double least = std::nan(""), greatest = least, squares = 0.0, count = 0.0;
      for (const double value : series.y)
        if (std::isfinite(value)) {
          least = std::fmin(least, value), greatest = std::fmax(greatest, value);
          squares += value * value, count += 1.0;
        }
      rows.push_back({series.label.empty() ? one.y_label : printable(series.label), fmt::format("{}", count),
                      fmt::format("{:.4g}", least), fmt::format("{:.4g}", greatest),
                      fmt::format("{:.4g}", std::sqrt(squares / count))});
    }
  html.open("details").element("summary", "In numbers");
  html.table(fmt::format("{}: {}", panel.title, panel.y_label), {"series", "points", "least", "greatest", "rms"}, rows);
  if (has_files)
    html.element("p",
                 fmt::format("All points: figures/{}.csv; as a drawing: figures/{}.svg", figure.name, figure.name));
  html.close().close();
  const bool is_wide = figure.panel_width_px > PlotFigure{}.panel_width_px;
  return {figure.name, html.html(), is_wide, figure.question};
}

namespace {

using Chosen = std::vector<const PageFigure*>;

void write_all(const Chosen& figures, HtmlWriter& html) {
  for (const bool wide : {true, false}) {
    Chosen own;
    for (const PageFigure* figure : figures)
      if (figure->is_wide == wide) own.push_back(figure);
    if (own.empty()) continue;
    html.open("div", {{"class", wide || own.size() == 1 ? "charts" : "clouds"}});
    for (const PageFigure* figure : own) html.markup(figure->markup);
    html.close();
  }
}

template <typename Counts>
Chosen those_of(const std::vector<PageFigure>& figures, std::string_view prefix, Counts counts) {
  Chosen own;
  for (const PageFigure& figure : figures)
    if (figure.name.starts_with(prefix) && counts(figure)) own.push_back(&figure);
  return own;
}

}  // namespace

bool write_figures(const std::vector<PageFigure>& figures, std::string_view prefix, HtmlWriter& html) {
  const Chosen own = those_of(figures, prefix, [](const PageFigure&) { return true; });
  write_all(own, html);
  return !own.empty();
}

void write_figures(const std::vector<PageFigure>& figures, std::string_view prefix, Question question,
                   bool without_first, HtmlWriter& html) {
  Chosen own = those_of(figures, prefix, [&](const PageFigure& figure) { return figure.question == question; });
  if (own.empty()) return;
  if (!without_first) write_all({own.front()}, html);
  own.erase(own.begin());
  if (own.empty()) return;
  html.open("details").element("summary",
                               own.size() == 1 ? "One more figure" : fmt::format("{} more figures", own.size()));
  write_all(own, html);
  html.close();
}

void write_math(const std::string& mathml, HtmlWriter& html) {
  html.open("div", {{"class", "math"}, {"tabindex", "0"}, {"role", "group"}, {"aria-label", "equation"}})
      .markup(mathml)
      .close();
}

std::string report_page(const RunResults& results, const FirstScreen& first, const std::vector<PageFigure>& figures) {
  std::vector<std::string> names;
  for (const Input& input : results.inputs) names.push_back(printable(input.prepared.name, 200));
  constexpr std::size_t most_names = 4;
  if (names.size() > most_names) names.resize(most_names), names.emplace_back("...");
  const ReportHeader& header = results.config.report;
  const std::string title = page_title(header, fmt::format("Equation of motion from {}", fmt::join(names, ", ")));
  return html_document(title, [&](HtmlWriter& html) {
    write_header(header, html);
    const ident::RangeResult* chosen = chosen_equation(results.ranges).range;
    const auto number = static_cast<std::size_t>(chosen == nullptr ? 0 : chosen - results.ranges.data());
    write_screen(first, figures, range_prefix(number), html);
    write_contents(contents_of(results), html);
    const std::vector<std::size_t> order = chosen_first(results);
    for (const std::size_t i : order) write_range(results.ranges[i], results, figures, i != order.front(), html);
    write_agreement(results, html);
    write_predictions(results.predictions, figures, html);
    write_record(results, figures, html);
    write_front_end(results, figures, html);
    write_repeat(results.config, html);
    write_words(html);
  });
}

std::string prediction_page(const ident::RecordPrediction& prediction, const std::string& equation,
                            const std::vector<std::string>& warnings) {
  std::vector<PageFigure> figures;
  prediction_figures({prediction}, [&](const PlotFigure& figure) { figures.push_back(page_figure(figure, false)); });
  return html_document(fmt::format("Prediction of {}", printable(prediction.recording, 200)), [&](HtmlWriter& html) {
    html.element("p", printable(equation)).element("p", coordinates_sentence({prediction.coordinates}));
    for (const std::string& warning : warnings) html.element("p", printable(warning, 400));
    write_predictions({prediction}, figures, html);
  });
}

}  // namespace apps
