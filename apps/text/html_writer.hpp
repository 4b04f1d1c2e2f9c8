#pragma once
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace apps {

/// Text as text in HTML, MathML and SVG, between tags and inside quotes: & < > " ' as entities, control and
/// direction-changing characters as printable() has them, what is not UTF-8 as U+FFFD. Line ends stay.
[[nodiscard]] std::string escaped_markup(std::string_view text);

/// A JSON document as the content of a script element, which nothing in it can end.
[[nodiscard]] std::string json_for_script(std::string_view document);

/// HTML being written, element by element. Whatever goes through text() and attributes is escaped here and nowhere
/// else.
class HtmlWriter {
 public:
  using Attributes = std::initializer_list<std::pair<std::string_view, std::string_view>>;
  /// <tag name="value" ...>
  HtmlWriter& open(std::string_view tag, Attributes attributes = {}) &;
  /// Ends the element opened last. Throws std::logic_error where none is open.
  HtmlWriter& close() &;
  /// An element that has no content: <br>, <meta ...>.
  HtmlWriter& empty(std::string_view tag, Attributes attributes = {}) &;
  HtmlWriter& text(std::string_view text) &;
  /// open, text, close.
  HtmlWriter& element(std::string_view tag, std::string_view text, Attributes attributes = {}) &;
  /// Markup that is ours, as it is.
  HtmlWriter& markup(std::string_view markup) &;
  /// A row of cells; the first heads the row.
  HtmlWriter& row(const std::vector<std::string>& cells) &;
  /// A whole table under its caption: a row of heads, then rows. Cells are text.
  HtmlWriter& table(std::string_view caption, const std::vector<std::string>& heads,
                    const std::vector<std::vector<std::string>>& rows) &;
  /// What was written. Throws std::logic_error where an element is still open.
  [[nodiscard]] const std::string& html() const&;
  void html() const&& = delete;

 private:
  void begin(std::string_view tag, Attributes attributes);
  std::string html_;
  std::vector<std::string> open_;
};

}  // namespace apps
