#include "apps/paper/replicate_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <map>

#include "apps/page/document.hpp"

namespace apps {
namespace {

using Strings = std::vector<std::string>;

/// What a row's quantity is called, and what its columns then mean.
struct Quantity {
  const char *name, *caption, *expected;
};
constexpr std::array quantities{
    Quantity{"mean", "Coefficients", "the true value, or the noise-free fit of the printed terms"},
    Quantity{"cov", "Coefficients of variation", "at the stated noise"},
    Quantity{"nmse", "Errors of the acceleration (NMSE)", ""},
    Quantity{"free_run", "Free runs of the printed and of our equations (NMSE)", "at the stated noise, on average"},
    Quantity{"seconds", "CPU seconds", ""}};

std::string number(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "-";
}

std::string verdict_of(const Comparison& row) {
  return row.verdict.reason.empty() ? row.verdict.verdict : row.verdict.verdict + ": " + row.verdict.reason;
}

/// "15 within noise, 2 misprint", in the order in which they come.
std::string verdict_counts(const std::vector<Comparison>& rows) {
  Strings order;
  std::map<std::string, int> counts;
  for (const Comparison& row : rows) {
    if (row.verdict.verdict.empty()) continue;
    if (counts[row.verdict.verdict]++ == 0) order.push_back(row.verdict.verdict);
  }
  Strings parts;
  for (const std::string& verdict : order) parts.push_back(fmt::format("{} {}", counts[verdict], verdict));
  return parts.empty() ? "-" : fmt::format("{}", fmt::join(parts, ", "));
}

void write_quantity(const ReplicatedItem& item, const Quantity& quantity, HtmlWriter& html) {
  std::vector<Strings> rows;
  bool expected = false;
  for (const Comparison& row : item.rows) {
    if (row.quantity != quantity.name) continue;
    expected = expected || std::isfinite(row.expected);
    rows.push_back({row.row, row.ratio > 0.0 ? fmt::format("{} at {:g}", row.term, row.ratio) : row.term, row.method,
                    number(row.paper), number(row.expected), number(row.ours), number(row.ours_std), verdict_of(row)});
  }
  if (rows.empty()) return;
  const std::string caption =
      fmt::format("{}. {}{}{}", item.title, quantity.caption,
                  expected && *quantity.expected != '\0' ? "; expected: " : "", expected ? quantity.expected : "");
  html.table(caption,
             {"row", "term", "method", "paper", "expected", "ours", "our standard deviation", "verdict on the print"},
             rows);
}

void write_item(const ReplicatedItem& item, HtmlWriter& html) {
  html.open("section", {{"id", item.name}}).element("h2", item.title);
  if (!item.svg.empty()) {
    const std::string id = "caption-" + item.name;
    html.open("figure", {{"class", "cloud"}, {"aria-labelledby", id}});
    html.open("div", {{"role", "img"}, {"aria-labelledby", id}}).markup(item.svg).close();
    html.element("figcaption", fmt::format("{}. As a file: {}.svg", item.title, item.name), {{"id", id}}).close();
  }
  for (const Quantity& quantity : quantities) write_quantity(item, quantity, html);
  if (!item.text.empty())
    html.open("details").element("summary", "The whole table as text").element("pre", item.text).close();
  html.close();
}

void write_overview(const std::vector<ReplicatedItem>& items, const std::string& summary, HtmlWriter& html) {
  html.element("p",
               "Numbers and figures of [QZS23] (docs/method.md) computed again: what the paper prints, what the method "
               "as stated there gives on average over draws of the noise (expected), and what this run found (ours). "
               "Where our own verdict is not 'within noise', its reason stands beside it. The paper's figures are not "
               "copied here; ours show the same quantities.");
  std::vector<Strings> rows;
  for (const ReplicatedItem& item : items)
    if (!item.rows.empty())
      rows.push_back({item.title, fmt::format("{}", item.rows.size()), verdict_counts(item.rows)});
  if (!rows.empty()) html.table("Printed numbers and their verdicts", {"table", "numbers", "verdicts"}, rows);
  if (!summary.empty()) html.element("pre", summary);
}

}  // namespace

std::string replicate_page(const std::vector<ReplicatedItem>& items, const std::string& summary) {
  return html_document("The paper's tables and figures, computed again", [&](HtmlWriter& html) {
    std::vector<PageLink> links;
    for (const ReplicatedItem& item : items) links.push_back({item.name, item.title});
    write_contents(links, html);
    write_overview(items, summary, html);
    for (const ReplicatedItem& item : items) write_item(item, html);
  });
}

}  // namespace apps
