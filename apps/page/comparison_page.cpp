#include "apps/page/comparison_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cctype>
#include <cmath>

#include "apps/page/document.hpp"
#include "apps/page/page_sections.hpp"
#include "apps/process/printable.hpp"
#include "dsp/values/constants.hpp"
#include "dsp/values/names.hpp"
#include "ident/equation/interval_95.hpp"

namespace apps {
namespace {

using dsp::nan;

std::string headline(const RangeComparison& range, std::size_t width) {
  std::string text = printable(range.heading, width);
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

PlotFigure term_figure(const RangeComparison& range, const std::string& term, std::string name) {
  std::vector<double> runs, means, ends, interval;
  std::string unit;
  for (std::size_t i = 0; i < range.columns.size(); ++i) {
    const nlohmann::ordered_json* own = term_of(range.columns[i], term);
    if (own == nullptr) continue;
    const auto run = static_cast<double>(i + 1);
    const double mean = own->at("mean").is_number() ? own->at("mean").get<double>() : nan;
    const double std = own->at("std").is_number() ? own->at("std").get<double>() : nan;
    unit = own->value("unit", "");
    runs.push_back(run);
    means.push_back(mean);
    ends.insert(ends.end(), {run, run, run});
    interval.insert(interval.end(), {mean - ident::interval_95 * std, mean + ident::interval_95 * std, nan});
  }
  const double last = static_cast<double>(range.columns.size()) + 0.5;
  const std::string of = range.of_coefficients ? "coefficient of " + term : term;
  PlotPanel panel{of, "run (number in the table)", unit.empty() ? "no unit" : unit};
  panel.series = {
      plot_series("95 % interval", ends, interval, PlotStyle::line, PlotColour::blue),
      plot_series(range.of_coefficients ? "coefficient" : "value", runs, means, PlotStyle::points, PlotColour::black)};
  const auto known = range.truth.find(term);
  if (known != range.truth.end())
    panel.series.push_back(plot_series("true value", {0.5, last}, {known->second, known->second}, PlotStyle::dashed,
                                       PlotColour::vermilion));
  panel.x_limits = {0.5, last};
  constexpr std::size_t most_names = 15;
  for (std::size_t run = 0; run <= range.columns.size() && range.columns.size() <= most_names; ++run)
    panel.x_names.push_back(fmt::format("{}", run));
  return drawing(
      std::move(name),
      fmt::format(
          "{} by run, with 95 % intervals{}", range.of_coefficients ? "Coefficient of " + term : term,
          known == range.truth.end() ? ". Runs agree where intervals overlap by half." : ", and its true value."),
      std::move(panel));
}

std::vector<std::string> heads_of(const TextGrid& grid, bool numbered) {
  std::vector<std::string> heads{grid.corner};
  std::size_t number = 0;
  for (const std::string& column : grid.columns)
    heads.push_back(numbered && column != "truth" ? fmt::format("{}: {}", ++number, column) : column);
  return heads;
}

void write_grid(const std::string& caption, const TextGrid& grid, bool numbered, HtmlWriter& html) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < grid.rows.size(); ++i) {
    rows.push_back({grid.rows[i]});
    rows.back().insert(rows.back().end(), grid.cells[i].begin(), grid.cells[i].end());
  }
  html.table(caption, heads_of(grid, numbered), rows);
}

void write_changes(const RunComparison& comparison, HtmlWriter& html) {
  html.open("section", {{"id", "changes"}}).element("h2", "What differs");
  if (comparison.changes.empty())
    html.element("p", "No difference: the same inputs, settings and program.");
  else
    write_grid("Program, inputs and settings that are not the same in all runs", changes_grid(comparison), false, html);
  html.close();
}

void write_range(const RunComparison& comparison, std::size_t index, const std::vector<PageFigure>& figures,
                 HtmlWriter& html) {
  const RangeComparison& range = comparison.ranges[index];
  html.open("section", {{"id", fmt::format("range-{}", index + 1)}}).element("h2", headline(range, 200));
  write_grid("Verdict, coefficients and errors", grid_of(range), true, html);
  html.element("p", range.truth.empty()
                        ? "In brackets: the difference from the first run in standard deviations of that difference; "
                          "beyond 3 the runs do not agree. -: the term was not kept."
                        : "inside, outside: the true value is in the 95 % interval or not. -: the term was not kept.");
  write_figures(figures, range_prefix(index), html);
  html.close();
}

}  // namespace

std::vector<PlotFigure> comparison_figures(const RunComparison& comparison) {
  constexpr std::size_t most_runs = 60;
  std::vector<PlotFigure> figures;
  if (comparison.titles.size() > most_runs) return figures;
  for (std::size_t i = 0; i < comparison.ranges.size(); ++i) {
    const RangeComparison& range = comparison.ranges[i];
    for (std::size_t k = 0; k < range.terms.size(); ++k) {
      std::size_t having = 0;
      for (const ComparedColumn& column : range.columns)
        having += term_of(column, range.terms[k].label) != nullptr ? 1 : 0;
      if (having < 2 && range.truth.empty()) continue;
      const std::string& label = range.terms[k].label;
      figures.push_back(term_figure(range, label, fmt::format("{}{}-{}", range_prefix(i), k + 1, dsp::slug(label))));
    }
  }
  return figures;
}

std::string comparison_page(const RunComparison& comparison, const std::vector<PlotFigure>& figures) {
  std::vector<PageFigure> shown;
  for (const PlotFigure& figure : figures) shown.push_back(page_figure(figure, true));
  std::vector<std::string> names;
  constexpr std::size_t most_names = 4;
  for (const std::string& title : comparison.titles) names.push_back(printable(title, 100));
  if (names.size() > most_names) names.resize(most_names), names.emplace_back("...");
  return html_document(fmt::format("Runs side by side: {}", fmt::join(names, ", ")), [&](HtmlWriter& html) {
    std::vector<PageLink> links;
    if (comparison.titles.size() > 1) links.push_back({"changes", "What differs"});
    for (std::size_t i = 0; i < comparison.ranges.size(); ++i)
      links.push_back({fmt::format("range-{}", i + 1), headline(comparison.ranges[i], 60)});
    write_contents(links, html);
    if (comparison.titles.size() > 1) write_changes(comparison, html);
    for (std::size_t i = 0; i < comparison.ranges.size(); ++i) write_range(comparison, i, shown, html);
  });
}

}  // namespace apps
