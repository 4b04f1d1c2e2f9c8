// What docs/words.md forbids is in no sentence that a user can meet: texts of the sources, pages, documents.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/scratch.hpp"

namespace {

namespace fs = std::filesystem;

/// In lower case, each run of white space as one blank.
std::string plain(std::string_view text) {
  std::string result;
  for (const char c : text)
    if (std::isspace(static_cast<unsigned char>(c)) == 0)
      result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!result.empty() && result.back() != ' ')
      result += ' ';
  return result;
}

/// Where the literal that opens at `at` ends: behind its closing quote.
std::size_t end_of_literal(std::string_view code, std::size_t at) {
  for (std::size_t i = at + 1; i < code.size(); ++i)
    if (code[i] == '\\')
      ++i;
    else if (code[i] == code[at])
      return i + 1;
  return code.size();
}

/// String literals of C++, those that stand beside one another joined; no comments.
std::vector<std::string> literals(std::string_view code) {
  std::vector<std::string> found;
  bool joins = false;
  for (std::size_t i = 0; i < code.size();) {
    const auto skip_to = [&](std::string_view end) {
      i = std::min(code.find(end, i), code.size() - end.size()) + end.size();
    };
    if (code.substr(i, 2) == "//") {
      skip_to("\n");
    } else if (code.substr(i, 2) == "/*") {
      skip_to("*/");
    } else if (code[i] == '\'' && i > 0 && std::isalnum(static_cast<unsigned char>(code[i - 1])) != 0) {
      ++i;  // between digits
    } else if (code[i] == '"' || code[i] == '\'') {
      const std::size_t end = end_of_literal(code, i);
      const std::string text(code.substr(i + 1, end - i - 2));
      if (code[i] == '"' && joins)
        found.back() += text;
      else if (code[i] == '"')
        found.push_back(text);
      joins = code[i] == '"';
      i = end;
    } else {
      joins = joins && std::isspace(static_cast<unsigned char>(code[i])) != 0;
      ++i;
    }
  }
  return found;
}

/// Expressions in the first column of the last table, between backticks.
std::vector<std::string> forbidden_expressions() {
  const std::string text = support::bytes_of(fs::path(ARDENT_SOURCES) / "docs/words.md");
  std::vector<std::string> found;
  constexpr std::string_view begin = "\n| `";
  for (std::size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at + 1)) {
    const std::size_t from = at + begin.size();
    found.push_back(text.substr(from, text.find('`', from) - from));
  }
  return found;
}

/// As words of their own: "told" is not in "toldo".
bool holds(const std::string& sentence, const std::string& expression) {
  const auto is_letter = [&](std::size_t i) {
    return i < sentence.size() && std::isalpha(static_cast<unsigned char>(sentence[i])) != 0;
  };
  for (std::size_t at = sentence.find(expression); at != std::string::npos; at = sentence.find(expression, at + 1))
    if ((at == 0 || !is_letter(at - 1)) && !is_letter(at + expression.size())) return true;
  return false;
}

/// Sentences with the file they are in.
std::vector<std::pair<std::string, std::string>> sentences() {
  std::vector<std::pair<std::string, std::string>> all;
  const fs::path root = ARDENT_SOURCES;
  for (const char* folder : {"apps", "dsp", "ident", "sim"})
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string ending = entry.path().extension().string();
      if (ending == ".cpp" || ending == ".hpp")
        for (const std::string& text : literals(support::bytes_of(entry.path())))
          all.emplace_back(fs::relative(entry.path(), root).string(), plain(text));
    }
  std::vector<fs::path> documents{root / "README.md", root / "run", root / "apps/main_job.sh",
                                  root / "apps/page/page.js"};
  for (const auto& entry : fs::directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md" && entry.path().filename() != "words.md") documents.push_back(entry.path());
  for (const fs::path& document : documents)
    all.emplace_back(fs::relative(document, root).string(), plain(support::bytes_of(document)));
  return all;
}

}  // namespace

TEST_CASE("literals are found and joined, comments are not", "[apps][words]") {
  CHECK(literals("f(\"a b \"\n  \"c\", 'x', 8'000); // \"no\"\n/* \"no\" */ g(\"d\\\"e\");") ==
        std::vector<std::string>{"a b c", "d\\\"e"});
  CHECK(holds("as they told us", "told"));
  CHECK_FALSE(holds("untold", "told"));
}

TEST_CASE("no sentence uses an expression that the word list forbids", "[apps][words]") {
  const std::vector<std::string> forbidden = forbidden_expressions();
  REQUIRE(forbidden.size() > 10);
  const auto all = sentences();
  REQUIRE(all.size() > 1000);
  for (const auto& [file, sentence] : all)
    for (const std::string& expression : forbidden)
      if (holds(sentence, plain(expression)))
        FAIL_CHECK(file << ": '" << expression << "' in: " << sentence.substr(0, 300));
}
