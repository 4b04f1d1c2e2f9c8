#include "apps/page/page_frame.hpp"

#include "apps/page/assets.hpp"

namespace apps {
namespace {

constexpr const char* policy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

}  // namespace

void open_page(const std::string& title, HtmlWriter& html) {
  html.markup("<!DOCTYPE html>\n").open("html", {{"lang", "en"}}).open("head");
  html.empty("meta", {{"charset", "utf-8"}})
      .empty("meta", {{"http-equiv", "Content-Security-Policy"}, {"content", policy}})
      .empty("meta", {{"name", "viewport"}, {"content", "width=device-width, initial-scale=1"}})
      .empty("link", {{"rel", "icon"}, {"href", "data:,"}})
      .element("title", title);
  html.open("style").markup(uplot_style()).markup(page_style()).close().close();
  html.open("body").open("main").element("h1", title);
}

}  // namespace apps
