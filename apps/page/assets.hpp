#pragma once
#include <string_view>

namespace apps {

// Files of this folder that the build puts into the program (embed.cmake), so that a page needs none beside it.

[[nodiscard]] std::string_view page_style();     ///< page.css
[[nodiscard]] std::string_view page_script();    ///< page.js
[[nodiscard]] std::string_view uplot_script();   ///< vendor/uPlot.iife.min.js
[[nodiscard]] std::string_view uplot_style();    ///< vendor/uPlot.min.css
[[nodiscard]] std::string_view uplot_licence();  ///< vendor/uPlot-LICENSE

}  // namespace apps
