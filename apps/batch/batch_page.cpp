#include "apps/batch/batch_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/output/joint_report.hpp"
#include "apps/page/document.hpp"
#include "apps/page/equation_display.hpp"
#include "apps/page/page_sections.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/number_text.hpp"
#include "apps/text/svg_plot.hpp"
#include "dsp/values/order_statistics.hpp"
#include "ident/equation/interval_95.hpp"

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
  write_math(displayed_equation(fit.model, ident::Notation::mathml), html);
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
  if (!results.joint.empty())
    html.element("p",
                 "By regression on the filtered rows of all of them. A record's own page may rest on its samples as "
                 "they were recorded, whose standard deviations and errors are smaller.");
  if (!results.joint_reason.empty()) html.element("p", results.joint_reason);
  for (const std::string& warning : results.warnings) html.element("p", warning);
  for (const ident::JointResult& result : results.joint) {
    if (!result.left_out.empty()) html.element("p", fmt::format("Left out: {}", fmt::join(result.left_out, ", ")));
    if (const ident::JointFit* fit = shown_fit(result)) write_joint_fit(result, *fit, html);  // others: table.json
  }
}

/// A coefficient of the records that have it.
struct Coefficients {
  std::vector<std::size_t> records;
  std::vector<double> means, stds;
  std::string unit;

  /// Whether one lies further from the others' middle than their spread and its own uncertainty let expect.
  [[nodiscard]] std::vector<bool> outliers() const {
    constexpr double most_deviations = 4.0, std_of_median = 1.4826;  // of a normal distribution
    const double middle = dsp::median(means);
    std::vector<double> from_middle;
    for (const double mean : means) from_middle.push_back(std::abs(mean - middle));
    const double spread = std_of_median * dsp::median(from_middle);
    std::vector<bool> result;
    for (std::size_t i = 0; i < means.size(); ++i)
      result.push_back(from_middle[i] > most_deviations * std::hypot(spread, std::isfinite(stds[i]) ? stds[i] : 0.0));
    return result;
  }
};

Coefficients coefficients_of(const std::string& name, const BatchResults& results) {
  Coefficients found;
  for (std::size_t i = 0; i < results.records.size(); ++i)
    for (const Json& range : results.records[i].ranges)
      for (const Json& term : range.at("terms"))
        if (range.at("chosen") == true && term.at("name") == name && term.at("mean").is_number()) {
          found.records.push_back(i);
          found.means.push_back(term.at("mean"));
          found.stds.push_back(term.at("std").is_number() ? term.at("std").get<double>() : std::nan(""));
          found.unit = text(term.at("unit"));
        }
  return found;
}

/// A name by its end, in which those of a series differ.
std::string with_end(const std::string& name, std::size_t longest) {
  if (name.size() <= longest) return printable(name);
  std::size_t from = name.size() - longest;
  while (from < name.size() && (static_cast<unsigned char>(name[from]) & 0xC0U) == 0x80U) ++from;  // within a letter
  return "\u2026" + printable(name.substr(from));
}

/// The records below one another, the first on top, by name where there are not too many.
PlotPanel coefficient_panel(const std::string& name, const Coefficients& found, const BatchResults& results) {
  constexpr std::size_t most_names = 60, longest_name = 28;
  const auto n = static_cast<double>(results.records.size());
  std::vector<double> ends, interval, places[2], means[2];
  const std::vector<bool> outliers = found.outliers();
  for (std::size_t i = 0; i < found.records.size(); ++i) {
    const double place = n - 1.0 - static_cast<double>(found.records[i]), half = ident::interval_95 * found.stds[i];
    ends.insert(ends.end(), {place, place, place});
    interval.insert(interval.end(), {found.means[i] - half, found.means[i] + half, std::nan("")});
    places[outliers[i]].push_back(place);
    means[outliers[i]].push_back(found.means[i]);
  }
  PlotPanel panel{name, fmt::format("coefficient ({})", found.unit.empty() ? "no unit" : found.unit), ""};
  panel.y_limits = {-0.7, n - 0.3};
  if (results.records.size() <= most_names)
    for (auto record = results.records.rbegin(); record != results.records.rend(); ++record)
      panel.y_names.push_back(with_end(record->recording, longest_name));
  else
    panel.y_label = "record, the first on top";
  panel.series = {plot_series("95 %", interval, ends, PlotStyle::line, PlotColour::blue),
                  plot_series("", means[0], places[0], PlotStyle::points, PlotColour::black)};
  if (!means[1].empty())
    panel.series.push_back(
        plot_series("unlike the others", means[1], places[1], PlotStyle::points, PlotColour::vermilion));
  return panel;
}

void write_coefficients(const BatchResults& results, HtmlWriter& html) {
  constexpr std::size_t most_terms = 8;
  constexpr double row_px = 20.0, frame_px = 90.0, least_px = 180.0, most_px = 1400.0;
  PlotFigure figure;
  figure.name = "coefficients";
  figure.panel_height_px =
      std::clamp(frame_px + row_px * static_cast<double>(results.records.size()), least_px, most_px);
  std::vector<std::string> names = all_terms(results.records);
  if (names.size() > most_terms) names.resize(most_terms);
  for (const std::string& name : names)
    if (const Coefficients found = coefficients_of(name, results); !found.means.empty())
      figure.panels.push_back(coefficient_panel(name, found, results));
  if (figure.panels.empty()) return;
  html.element("h2", "Coefficients over the records");
  html.open("figure", {{"class", "drawing"}, {"aria-labelledby", "coefficients"}}).markup(to_svg(figure));
  html.open("div", {{"class", "tools"}, {"data-name", "coefficients"}}).close();
  html.element("figcaption",
               "Of each record's chosen equation, with its 95 % interval. Unlike the others: further from their middle "
               "than four standard deviations of their spread and its own. Numbers are in table.csv.",
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
  const std::string title = page_title(
      results.header, fmt::format("{} record{}{}", results.records.size(), results.records.size() == 1 ? "" : "s",
                                  results.config.empty() ? "" : " by " + results.config));
  return html_document(title, [&](HtmlWriter& html) {
    write_header(results.header, html);
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
  return text + joint_text(results.joint, few);
}

}  // namespace apps
