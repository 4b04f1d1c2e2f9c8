#include "apps/reference/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace apps {
namespace {

constexpr std::size_t page_width = 88, text_column = 24;

/// Calls `take` with each paragraph of a text: they are separated by empty lines.
template <class Take>
void for_each_paragraph(std::string_view text, Take&& take) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find("\n\n"), text.size());
    take(text.substr(0, end));
    text.remove_prefix(std::min(end + 2, text.size()));
  }
}

/// Words in lines of at most `page_width`, each behind `indent` blanks; the first is appended to what stands in `line`.
std::string wrapped(std::string line, std::string_view text, std::size_t indent) {
  std::string result;
  bool empty = true;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find_first_of(" \n", from), text.size());
    const std::string_view word = text.substr(from, end - from);
    from = end + 1;
    if (word.empty()) continue;
    if (!empty && line.size() + 1 + word.size() > page_width) {
      result += line + "\n";
      line.assign(indent, ' ');
      empty = true;
    }
    if (!empty) line += ' ';
    line += word;
    empty = false;
  }
  return result + line + "\n";
}

std::string entry_text(const HelpEntry& entry) {
  std::string line = "  " + entry.term, result;
  if (line.size() + 2 > text_column) {
    result = line + "\n";
    line.clear();
  }
  line.resize(text_column, ' ');
  result += wrapped(line, entry.text, text_column);
  if (!entry.facts.empty()) result += wrapped(std::string(text_column, ' '), entry.facts, text_column);
  return result;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

/// Text in a manual page: nothing in it is a request.
std::string escaped(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\')
      result += "\\e";
    else if (text[i] == '-')
      result += "\\-";
    else if ((text[i] == '.' || text[i] == '\'') && (i == 0 || text[i - 1] == '\n'))
      result += fmt::format("\\&{}", text[i]);
    else
      result += text[i];
  }
  return result;
}

/// Markdown takes these for marks of its own outside code.
std::string marked_down(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (std::string_view("*<>|").find(c) != std::string_view::npos) result += '\\';
    result += c;
  }
  return result;
}

}  // namespace

std::string to_text(const Page& page) {
  std::string text = wrapped("", fmt::format("{}: {}.", page.name, page.summary), 0);
  if (!page.usage.empty()) text += fmt::format("\n  {}\n", page.usage);
  for (const Section& section : page.sections) {
    text += section.heading.empty() ? "\n" : fmt::format("\n{}\n", section.heading);
    bool first = true;
    for_each_paragraph(section.text, [&](std::string_view paragraph) {
      text += (first ? "" : "\n") + wrapped("  ", paragraph, 2);
      first = false;
    });
    for (const HelpEntry& entry : section.entries) text += entry_text(entry);
    for (const std::string& line : section.code) text += line.empty() ? "\n" : "    " + line + "\n";
  }
  return text;
}

std::string to_markdown(const Page& page, int level) {
  const std::string marks(static_cast<std::size_t>(level), '#');
  std::string text = fmt::format("{} {}\n\n{}.\n", marks, page.name, marked_down(page.summary));
  if (!page.usage.empty()) text += fmt::format("\n    {}\n", page.usage);
  for (const Section& section : page.sections) {
    if (!section.heading.empty()) text += fmt::format("\n{}# {}\n", marks, marked_down(section.heading));
    for_each_paragraph(section.text,
                       [&](std::string_view paragraph) { text += "\n" + wrapped("", marked_down(paragraph), 0); });
    if (!section.entries.empty()) text += "\n";
    for (const HelpEntry& entry : section.entries)
      text += wrapped(
          fmt::format("- `{}` ", entry.term),
          marked_down(entry.text) + (entry.facts.empty() ? "" : fmt::format(" *{}*", marked_down(entry.facts))), 2);
    if (!section.code.empty()) text += "\n";
    for (const std::string& line : section.code) text += line.empty() ? "\n" : "    " + line + "\n";
  }
  return text;
}

std::string to_manual(const Page& page, int section, const std::string& version) {
  const std::string title = section == 1 && page.name == "ardent" ? "ardent" : "ardent-" + page.name;
  std::string text = fmt::format(".TH \"{}\" {} \"\" \"ardent {}\"\n.nh\n.ad l\n.SH NAME\n{} \\- {}\n",
                                 upper(escaped(title)), section, version, escaped(title), escaped(page.summary));
  if (!page.usage.empty()) text += fmt::format(".SH SYNOPSIS\n{}\n", escaped(page.usage));
  for (const Section& part : page.sections) {
    text += fmt::format(".SH {}\n", part.heading.empty() ? "DESCRIPTION" : upper(escaped(part.heading)));
    bool first = true;
    for_each_paragraph(part.text, [&](std::string_view paragraph) {
      text += (first ? "" : ".PP\n") + escaped(paragraph) + "\n";
      first = false;
    });
    for (const HelpEntry& entry : part.entries) {
      text += fmt::format(".TP\n.B {}\n{}\n", escaped(entry.term), escaped(entry.text));
      if (!entry.facts.empty()) text += fmt::format(".br\n{}\n", escaped(entry.facts));
    }
    if (part.code.empty()) continue;
    text += ".PP\n.nf\n.RS\n";
    for (const std::string& line : part.code) text += escaped(line) + "\n";
    text += ".RE\n.fi\n";
  }
  return text;
}

}  // namespace apps
