#pragma once
#include "apps/output/html_writer.hpp"
#include "apps/page/first_screen.hpp"

namespace apps {

/// A first screen as the top of a page.
void write_screen(const FirstScreen& screen, HtmlWriter& html);

}  // namespace apps
