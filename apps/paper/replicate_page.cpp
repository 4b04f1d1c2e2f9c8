#include "apps/paper/replicate_page.hpp"

#include <fmt/ranges.h>

#include "apps/page/document.hpp"
#include "apps/paper/paper_data.hpp"
#include "apps/paper/tables.hpp"

namespace apps {
namespace {

/// "15 within noise, 2 misprint", in the order in which they come.
std::string verdict_counts(const JsonRows& rows) {
  std::vector<std::string> parts;
  for (const auto& [verdict, same] : grouped(rows, {"verdict"}))
    parts.push_back(fmt::format("{} {}", same.size(), verdict[0].get<std::string>()));
  return fmt::format("{}", fmt::join(parts, ", "));
}

void write_table(const ReplicatedItem& item, const PaperTable& table, HtmlWriter& html) {
  std::vector<std::string> heads;
  for (const std::string& head : table.heads) heads.push_back(head.substr(1));
  html.table(item.title + ". " + table.caption, heads, table.rows);
}

void write_item(const ReplicatedItem& item, HtmlWriter& html) {
  html.open("section", {{"id", item.name}}).element("h2", item.title);
  if (!item.svg.empty()) {
    const std::string id = "caption-" + item.name;
    html.open("figure", {{"class", "cloud"}, {"aria-labelledby", id}});
    html.open("div", {{"role", "img"}, {"aria-labelledby", id}}).markup(item.svg).close();
    html.element("figcaption", fmt::format("{}. As a file: {}.svg", item.title, item.name), {{"id", id}}).close();
  }
  for (const PaperTable& table : compared_tables(item.rows)) write_table(item, table, html);
  if (!item.text.empty())
    html.open("details").element("summary", "The whole table as text").element("pre", item.text).close();
  html.close();
}

}  // namespace

std::string replicate_page(const std::vector<ReplicatedItem>& items, const std::string& summary) {
  return html_document("The paper's tables and figures, computed again", [&](HtmlWriter& html) {
    std::vector<PageLink> links;
    std::vector<std::vector<std::string>> rows;
    for (const ReplicatedItem& item : items) {
      links.push_back({item.name, item.title});
      if (!item.rows.empty())
        rows.push_back({item.title, fmt::format("{}", item.rows.size()), verdict_counts(item.rows)});
    }
    write_contents(links, html);
    html.element("p", paper_sentences().text("page").value());
    if (!rows.empty()) html.table("Printed numbers and their verdicts", {"table", "numbers", "verdicts"}, rows);
    if (!summary.empty()) html.element("pre", summary);
    for (const ReplicatedItem& item : items) write_item(item, html);
  });
}

}  // namespace apps
