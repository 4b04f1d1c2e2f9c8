#include "apps/page/screen_html.hpp"

#include <algorithm>
#include <optional>

namespace apps {
namespace {

using Entry = FirstScreen::Entry;

const char* colour_of(std::optional<ident::Verdict> verdict) {
  if (verdict == ident::Verdict::describes) return "badge good";
  if (verdict == ident::Verdict::in_part) return "badge fair";
  return verdict == ident::Verdict::does_not ? "badge bad" : "badge open";
}

void write_lines(const std::vector<FirstScreen::Line>& lines, HtmlWriter& html) {
  std::string to_paste;
  const auto paste = [&] {
    if (!to_paste.empty()) html.element("pre", to_paste, {{"class", "copied"}});
    to_paste.clear();
  };
  for (const FirstScreen::Line& line : lines) {
    if (line.to_paste) {
      to_paste += line.text + "\n";
      continue;
    }
    paste();
    html.element("p", line.text);
  }
  paste();
}

void write_claim(const FirstScreen& screen, HtmlWriter& html) {
  const FirstScreen::Answer& answer = screen.answer;
  html.open("p", {{"class", "verdict"}})
      .element("span", answer.verdict ? in_words(*answer.verdict) : "no equation",
               {{"class", colour_of(answer.verdict)}})
      .text(" " + answer.sentence)
      .close();
  for (const Entry& entry : screen.entries)
    if (entry.label.empty()) write_lines(entry.lines, html);  // it is about all of it
  const bool is_doubtful = answer.verdict == ident::Verdict::does_not;
  html.open("div", {{"class", is_doubtful ? "equations doubtful" : "equations"}});
  for (const std::string& equation : answer.equations) write_math(equation, html);
  if (!answer.symbols.empty()) html.element("p", answer.symbols + ".", {{"class", "small"}});
  html.close();
  if (answer.quantities.empty()) return;
  html.open("dl", {{"class", "quantities"}});
  constexpr std::size_t most = 4;  // all of them are in the words below
  for (std::size_t i = 0; i < std::min(most, answer.quantities.size()); ++i) {
    const FirstScreen::Answer::Quantity& one = answer.quantities[i];
    html.open("div").element("dt", one.name).open("dd").text(one.value + " ").element("span", one.unit).close().close();
  }
  html.close();
  if (!answer.accuracy.empty()) html.element("p", answer.accuracy, {{"class", "small"}});
}

}  // namespace

void write_screen(const FirstScreen& screen, const std::vector<PageFigure>& figures, std::string_view prefix,
                  HtmlWriter& html) {
  html.open("section", {{"class", "answer"}, {"aria-label", "answer"}}).open("div", {{"class", "claim"}});
  write_claim(screen, html);
  html.close();
  const auto proof = std::find_if(figures.begin(), figures.end(), [&](const PageFigure& figure) {
    return figure.name.starts_with(prefix) && figure.question == Question::follows;
  });
  if (proof != figures.end()) html.open("div", {{"class", "proof"}}).markup(proof->markup).close();
  const auto is_remedy = [](const Entry& entry) { return entry.label == "mend"; };
  const bool is_well = screen.answer.verdict == ident::Verdict::describes;  // there is nothing that must be mended
  for (const Entry& entry : screen.entries) {
    if (!is_remedy(entry)) continue;
    html.open("div", {{"class", is_well ? "mend" : "mend needed"}}).element("h2", "What to do next");
    write_lines(entry.lines, html);
    html.close();
  }
  html.close();
  html.open("dl", {{"class", "first"}});
  for (const Entry& entry : screen.entries) {
    if (is_remedy(entry) || entry.label.empty()) continue;
    html.element("dt", entry.label).open("dd");
    write_lines(entry.lines, html);
    html.close();
  }
  html.close();
}

}  // namespace apps
