#pragma once
#include <functional>
#include <string>
#include <vector>

#include "apps/config/config.hpp"
#include "apps/text/html_writer.hpp"

namespace apps {

/// A page that asks for nothing else: head with policy and style, <main> with the title and what `body` writes, the
/// licence of what draws the charts, scripts. The same bytes for the same content.
[[nodiscard]] std::string html_document(const std::string& title, const std::function<void(HtmlWriter&)>& body);

/// As it is stated, or this one.
[[nodiscard]] std::string page_title(const ReportHeader& header, const std::string& otherwise);

/// Object, test, operator and date below the title, those that are stated.
void write_header(const ReportHeader& header, HtmlWriter& html);

/// A link of a page's contents: to the element of this id.
struct PageLink {
  std::string id, text;
};
void write_contents(const std::vector<PageLink>& links, HtmlWriter& html);

}  // namespace apps
