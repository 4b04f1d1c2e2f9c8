#include "apps/text/html_writer.hpp"

#include <algorithm>
#include <stdexcept>

#include "apps/process/printable.hpp"

namespace apps {
namespace {

std::size_t longest_word(std::string_view text) {
  std::size_t longest = 0, length = 0;
  for (const char c : text) longest = std::max(longest, length = c == ' ' ? 0 : length + 1);
  return longest;
}

}  // namespace

std::string escaped_markup(std::string_view text) {
  std::string out;
  for (const char c : printable_lines(text)) switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  return out;
}

std::string json_for_script(std::string_view document) {
  std::string out;
  out.reserve(document.size());
  for (const char c : document)
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  return out;
}

void HtmlWriter::begin(std::string_view tag, Attributes attributes) {
  html_ += '<';
  html_ += tag;
  for (const auto& [name, value] : attributes) {
    html_ += ' ';
    html_ += name;
    html_ += "=\"" + escaped_markup(value) + '"';
  }
  html_ += '>';
}

HtmlWriter& HtmlWriter::open(std::string_view tag, Attributes attributes) & {
  begin(tag, attributes);
  open_.emplace_back(tag);
  return *this;
}

HtmlWriter& HtmlWriter::close() & {
  if (open_.empty()) throw std::logic_error("no element is open");
  html_ += "</" + open_.back() + ">\n";
  open_.pop_back();
  return *this;
}

HtmlWriter& HtmlWriter::empty(std::string_view tag, Attributes attributes) & {
  begin(tag, attributes);
  return *this;
}

HtmlWriter& HtmlWriter::text(std::string_view text) & {
  html_ += escaped_markup(text);
  return *this;
}

HtmlWriter& HtmlWriter::element(std::string_view tag, std::string_view content, Attributes attributes) & {
  return open(tag, attributes).text(content).close();
}

HtmlWriter& HtmlWriter::markup(std::string_view markup) & {
  html_ += markup;
  return *this;
}

HtmlWriter& HtmlWriter::row(const std::vector<std::string>& cells) & {
  constexpr std::size_t short_cell = 26;  // numbers and names, which stay on one line
  constexpr std::size_t long_word = 40;   // no word, which may break anywhere
  open("tr");
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (i == 0 && !cells[i].empty())
      element("th", cells[i], {{"scope", "row"}});
    else if (cells[i].size() <= short_cell)
      element("td", cells[i], {{"class", "short"}});
    else if (longest_word(cells[i]) > long_word)
      element("td", cells[i], {{"class", "long"}});
    else
      element("td", cells[i]);
  return close();
}

HtmlWriter& HtmlWriter::table(std::string_view caption, const std::vector<std::string>& heads,
                              const std::vector<std::vector<std::string>>& rows) & {
  open("div", {{"class", "table"}, {"tabindex", "0"}, {"role", "group"}, {"aria-label", caption}});
  open("table").element("caption", caption).open("thead").open("tr");
  for (const std::string& head : heads) head.empty() ? element("td", "") : element("th", head, {{"scope", "col"}});
  close().close().open("tbody");
  for (const std::vector<std::string>& cells : rows) row(cells);
  return close().close().close();
}

const std::string& HtmlWriter::html() const& {
  if (!open_.empty()) throw std::logic_error("still open: " + open_.back());
  return html_;
}

}  // namespace apps
