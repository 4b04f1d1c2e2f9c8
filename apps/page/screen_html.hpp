#pragma once
#include "apps/page/first_screen.hpp"
#include "apps/page/page_sections.hpp"
#include "apps/text/html_writer.hpp"

namespace apps {

/// A first screen as the top of a page: the verdict, the equation, what it means, the figure that shows it (of those
/// whose names begin so) and what to mend; then the words of the terminal.
void write_screen(const FirstScreen& screen, const std::vector<PageFigure>& figures, std::string_view prefix,
                  HtmlWriter& html);

}  // namespace apps
