#include "apps/page/document.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "apps/page/assets.hpp"
#include "apps/process/printable.hpp"
#include "apps/process/version.hpp"

namespace apps {
namespace {

constexpr const char* policy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

void write_head(const std::string& title, HtmlWriter& html) {
  html.markup("<!DOCTYPE html>\n").open("html", {{"lang", "en"}}).open("head");
  html.empty("meta", {{"charset", "utf-8"}})
      .empty("meta", {{"http-equiv", "Content-Security-Policy"}, {"content", policy}})
      .empty("meta", {{"name", "viewport"}, {"content", "width=device-width, initial-scale=1"}})
      .empty("link", {{"rel", "icon"}, {"href", "data:,"}})
      .element("title", title);
  html.open("style").markup(uplot_style()).markup(page_style()).close().close();
}

}  // namespace

std::string html_document(const std::string& title, const std::function<void(HtmlWriter&)>& body) {
  HtmlWriter html;
  write_head(title, html);
  html.open("body").open("main").element("h1", title);
  body(html);
  html.close();
  html.open("footer").element("p", "Written by Ardent " + version() + ". Charts: uPlot, MIT licence:");
  html.open("details").element("summary", "licence of uPlot").element("pre", uplot_licence()).close().close();
  html.open("script").markup(uplot_script()).close().open("script").markup(page_script()).close();
  html.close().close();
  return html.html();
}

std::string page_title(const ReportHeader& header, const std::string& otherwise) {
  return printable(header.title.empty() ? otherwise : header.title, 200);
}

void write_header(const ReportHeader& header, HtmlWriter& html) {
  const std::pair<const char*, const std::string&> entries[] = {
      {"object", header.object}, {"test", header.test}, {"operator", header.operator_name}, {"date", header.date}};
  const auto is_stated = [](const auto& entry) { return !entry.second.empty(); };
  if (std::none_of(std::begin(entries), std::end(entries), is_stated)) return;
  html.open("dl", {{"class", "header"}});
  for (const auto& [name, value] : entries)
    if (!value.empty()) html.open("div").element("dt", name).element("dd", printable(value, 200)).close();
  html.close();
}

void write_contents(const std::vector<PageLink>& links, HtmlWriter& html) {
  html.open("nav", {{"aria-label", "contents"}}).open("ul");
  for (const PageLink& link : links) html.open("li").element("a", link.text, {{"href", "#" + link.id}}).close();
  html.close().close();
}

}  // namespace apps
