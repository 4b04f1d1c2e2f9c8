#include "apps/batch/batch_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/output/joint_report.hpp"
#include "apps/output/number_text.hpp"
#include "apps/output/svg_plot.hpp"
#include "apps/page/document.hpp"
#include "apps/page/equation_display.hpp"
#include "apps/process/printable.hpp"

namespace apps {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

std::string digits_or_none(const Json& number) {
  return number.is_number() ? three_digits(number.get<double>()) : "none";
}
std::string text(const Json& member) {
  return member.is_string() ? member.get<std::string>() : "";
}

std::vector<const RecordResult*> with_errors(const BatchResults& results) {
  std::vector<const RecordResult*> found;
  for (const RecordResult& record : results.records)
    if (!record.error.empty()) found.push_back(&record);
  return found;
}

std::size_t count_of(const BatchResults& results, bool (*counts)(const RecordResult&)) {
  return static_cast<std::size_t>(std::count_if(results.records.begin(), results.records.end(), counts));
}

/// "64 records: 63 with results (describes 60, in_part 3), 1 without".
std::string counts_text(const BatchResults& results) {
  const std::size_t with = count_of(results, [](const RecordResult& record) { return !record.run.empty(); });
  std::vector<std::string> verdicts;
  for (const char* verdict : {"describes", "in_part", "undecided", "does_not"}) {
    std::size_t count = 0;
    for (const RecordResult& record : results.records)
      count += std::any_of(record.ranges.begin(), record.ranges.end(), [&](const Json& range) {
        return range.at("chosen") == true && range.at("verdict") == verdict;
      });
    if (count > 0) verdicts.push_back(fmt::format("{} {}", verdict, count));
  }
  return fmt::format("{} records: {} with results{}, {} without", results.records.size(), with,
                     verdicts.empty() ? "" : fmt::format(" ({})", fmt::join(verdicts, ", ")),
                     results.records.size() - with);
}

void write_errors(const BatchResults& results, HtmlWriter& html) {
  std::vector<std::vector<std::string>> rows;
  for (const RecordResult* record : with_errors(results))
    rows.push_back({record->recording, fmt::format("{}", record->exit_code), printable(record->error, 400)});
  if (rows.empty()) return;
  html.element("h2", "What went wrong");
  html.table("Records with an error", {"recording", "exit code", "error"}, rows);
}

void write_joint_fit(const ident::JointResult& result, const ident::JointFit& fit, HtmlWriter& html) {
  html.element("h3", fmt::format("Range {}, {}: {} records together", printable(result.range, 60),
                                 to_string(fit.fit.method), result.records.size()));
  html.open("div", {{"class", "math"}, {"tabindex", "0"}, {"role", "group"}, {"aria-label", "equation"}})
      .markup(displayed_equation(fit.model, ident::Notation::mathml))
      .close();
  for (const std::string& sentence : own_coefficient_sentences(fit.model)) html.element("p", sentence);
  std::vector<std::vector<std::string>> terms;
  for (std::size_t i = 0; i < fit.model.terms.size(); ++i) {
    const ident::ModelTerm& term = fit.model.terms[i];
    terms.push_back({label(term), ident::number(term.mean), three_digits(term.std),
                     three_digits(fit.std_over_records(static_cast<Index>(i))), term.unit});
  }
  html.table("Coefficients", {"term", "mean", "standard deviation", "over records", "unit"}, terms);
  std::vector<const ident::RecordCheck*> order = worst_first(fit);
  std::erase_if(order, [](const ident::RecordCheck* check) { return !std::isfinite(check->nmse_left_out); });
  constexpr std::size_t most = 20;
  if (order.size() > most) order.resize(most);
  std::vector<std::vector<std::string>> records;
  for (const ident::RecordCheck* check : order)
    records.push_back({printable(check->record, 60), three_digits(check->nmse), three_digits(check->nmse_left_out),
                       ident::to_text(check->left_out)});
  if (!records.empty())
    html.table("Records, the one that the others predict worst first",
               {"left out", "NMSE of the joint equation", "of the others' equation", "the others' equation"}, records);
}

void write_joint(const BatchResults& results, HtmlWriter& html) {
  html.element("h2", "All records together");
  if (!results.joint_reason.empty()) html.element("p", results.joint_reason);
  for (const std::string& warning : results.warnings) html.element("p", warning);
  for (const ident::JointResult& result : results.joint) {
    if (!result.left_out.empty()) html.element("p", fmt::format("Left out: {}", fmt::join(result.left_out, ", ")));
    for (const ident::JointFit& fit : result.fits)
      if (!fit.model.terms.empty()) {
        write_joint_fit(result, fit, html);
        break;  // the other methods are in table.json
      }
  }
}

/// Each coefficient over the records, in their order.
void write_coefficients(const BatchResults& results, HtmlWriter& html) {
  constexpr std::size_t most_terms = 8;
  PlotFigure figure;
  figure.name = "coefficients";
  std::vector<std::string> names = all_terms(results.records);
  if (names.size() > most_terms) names.resize(most_terms);
  const auto n = static_cast<double>(results.records.size());
  for (const std::string& name : names) {
    std::vector<double> x, y;
    std::string unit;
    for (std::size_t i = 0; i < results.records.size(); ++i)
      for (const Json& range : results.records[i].ranges)
        for (const Json& term : range.at("terms"))
          if (range.at("chosen") == true && term.at("name") == name && term.at("mean").is_number()) {
            x.push_back(static_cast<double>(i + 1));
            y.push_back(term.at("mean"));
            unit = text(term.at("unit"));
          }
    if (x.empty()) continue;
    PlotPanel panel{name, "record", fmt::format("coefficient ({})", unit), {}, std::pair{0.0, n + 1.0}};
    panel.series = {plot_series("", x, y, PlotStyle::points, PlotColour::blue)};
    figure.panels.push_back(std::move(panel));
  }
  if (figure.panels.empty()) return;
  html.element("h2", "Coefficients over the records");
  html.open("figure", {{"aria-labelledby", "coefficients"}}).markup(to_svg(figure));
  html.element("figcaption", "Of each record's chosen equation, in the order of the table below; numbers in table.csv.",
               {{"id", "coefficients"}});
  html.close();
}

void write_records(const BatchResults& results, HtmlWriter& html) {
  html.element("h2", "Every record").open("div", {{"class", "table"}}).open("table");
  html.element("caption", "The chosen equation of each; ranges of one record below one another")
      .open("thead")
      .open("tr");
  for (const char* head : {"record", "range", "verdict", "equation", "NMSE train", "test", "free run"})
    html.element("th", head, {{"scope", "col"}});
  html.close().close().open("tbody");
  for (const RecordResult& record : results.records) {
    const auto head = [&] {
      html.open("tr").open("th", {{"scope", "row"}});
      if (record.run.empty())
        html.text(record.recording);
      else
        html.element("a", record.recording, {{"href", record.run + "/report.html"}});
      html.close();
    };
    for (const Json& range : record.ranges) {
      head();
      html.element("td", text(range.at("name")), {{"class", "short"}});
      html.element("td", text(range.at("verdict")), {{"class", "short"}}).element("td", text(range.at("equation")));
      for (const char* key : {"train", "test", "free_run"})
        html.element("td", digits_or_none(range.at("nmse").at(key)), {{"class", "short"}});
      html.close();
    }
    if (!record.ranges.empty()) continue;
    head();
    html.element("td", printable(record.error, 400), {{"colspan", "6"}}).close();
  }
  html.close().close().close();
}

}  // namespace

std::string batch_page(const BatchResults& results) {
  const std::string title = fmt::format("{} records by {}", results.records.size(), printable(results.config, 200));
  return html_document(title, [&](HtmlWriter& html) {
    html.element("p", counts_text(results) + ".", {{"class", "verdict"}});
    write_errors(results, html);
    write_joint(results, html);
    write_coefficients(results, html);
    write_records(results, html);
  });
}

std::string batch_text(const BatchResults& results) {
  constexpr std::size_t most_lines = 10;
  std::string text = counts_text(results) + "\n";
  const std::vector<const RecordResult*> errors = with_errors(results);
  for (std::size_t i = 0; i < std::min(most_lines, errors.size()); ++i)
    text += fmt::format("  {}: {}\n", errors[i]->recording, printable(errors[i]->error, 300));
  if (errors.size() > most_lines) text += fmt::format("  and {} more, see table.csv\n", errors.size() - most_lines);
  if (!results.joint_reason.empty()) text += fmt::format("no joint fit: {}\n", results.joint_reason);
  constexpr std::size_t few = 5;
  std::vector<ident::JointResult> first = results.joint;
  for (ident::JointResult& result : first)
    if (result.fits.size() > 1) result.fits.resize(1);
  return text + joint_text(first, few);
}

}  // namespace apps
