#include "apps/text/html_writer.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>

using apps::HtmlWriter;

namespace {

const std::string hostile = "</script><script>alert(1)</script> \" ' & \xE2\x80\xAE gnp.exe \x1b[31m \xff";

}  // namespace

TEST_CASE("no text ends its element, its quotes or its line", "[apps][page]") {
  HtmlWriter html;
  html.open("p", {{"title", hostile}}).text(hostile).close();
  const std::string text = html.html();
  CHECK(std::count(text.begin(), text.end(), '<') == 2);
  CHECK(std::count(text.begin(), text.end(), '"') == 2);
  CHECK(text.find('\'') == std::string::npos);
  CHECK(text.find('\x1b') == std::string::npos);
  CHECK(text.find("\xE2\x80\xAE") == std::string::npos);  // no mark that turns what follows it round
  CHECK(text.find("\\u{202e}") != std::string::npos);     // but a reader sees that there was one
  CHECK(text.find("\xEF\xBF\xBD") != std::string::npos);  // nor bytes that are no text
  CHECK(text.find("&lt;script&gt;alert(1)") != std::string::npos);
}

TEST_CASE("JSON in a script element cannot end it and is the same document", "[apps][page]") {
  const nlohmann::json document{{"label", "</script><!--"}, {"n", 3}};
  const std::string script = apps::json_for_script(document.dump());
  CHECK(script.find('<') == std::string::npos);
  CHECK(nlohmann::json::parse(script) == document);
}

TEST_CASE("elements end in the order they began, all of them", "[apps][page]") {
  HtmlWriter html;
  html.open("div").open("p").text("a");
  CHECK_THROWS_AS((void)html.html(), std::logic_error);
  html.close().close();
  CHECK(html.html() == "<div><p>a</p>\n</div>\n");
  CHECK_THROWS_AS(html.close(), std::logic_error);
}

TEST_CASE("tables name their rows and columns for those who hear them", "[apps][page]") {
  HtmlWriter html;
  html.table("Coefficients", {"term", "value"}, {{"x", "-50"}});
  CHECK_THAT(html.html(), Catch::Contains("<caption>Coefficients</caption>") &&
                              Catch::Contains("<th scope=\"col\">value</th>") &&
                              Catch::Contains("<th scope=\"row\">x</th>"));
}
