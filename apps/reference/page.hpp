#pragma once
#include <string>
#include <vector>

namespace apps {

/// A name and what it means: an option, a key, a file.
struct HelpEntry {
  std::string term, text;
  std::string facts = {};  ///< type, default, unit: on a line of its own; empty: none
};

struct Section {
  std::string heading;
  std::string text = {};                ///< paragraphs, an empty line between
  std::vector<HelpEntry> entries = {};  ///< after the text
  std::vector<std::string> code = {};   ///< lines to be typed or pasted, last
};

/// A page of help, said once and printed as text, as Markdown or as a manual page.
struct Page {
  std::string name, summary;  ///< "run"; "From a recording to its equation of motion"
  std::string usage = {};     ///< "ardent run INPUT [options]"; empty: none
  std::vector<Section> sections = {};
};

/// For a terminal, 88 columns wide but for code.
[[nodiscard]] std::string to_text(const Page& page);
/// Under a heading of this level; `name` is its heading.
[[nodiscard]] std::string to_markdown(const Page& page, int level);
/// A manual page of this section (1: commands, 5: files), as man(7) sets it.
[[nodiscard]] std::string to_manual(const Page& page, int section, const std::string& version);

}  // namespace apps
