#pragma once
#include <string>

#include "apps/output/html_writer.hpp"

namespace apps {

/// What every page of ours begins with, to its heading: style inside, and nothing that may be asked for from anywhere.
/// Leaves html, body and main open.
void open_page(const std::string& title, HtmlWriter& html);

}  // namespace apps
