#pragma once
#include <string>
#include <vector>

#include "apps/page/first_screen.hpp"
#include "apps/text/svg_plot.hpp"
#include "ident/bodies/bodies.hpp"

// A run with several bodies, shown as one system.

namespace apps {

/// One equation a body, modes and couplings, the verdict, data and inputs.
[[nodiscard]] FirstScreen bodies_screen(const ident::BodiesResult& result, const ident::BodiesRecord& record);

/// Measured and free run of each body over the samples that were not fitted, then both over the record.
[[nodiscard]] std::vector<PlotFigure> bodies_figures(const ident::BodiesResult& result,
                                                     const ident::BodiesRecord& record);

/// report.html.
[[nodiscard]] std::string bodies_page(const ident::BodiesResult& result, const ident::BodiesRecord& record,
                                      const std::vector<PlotFigure>& figures, const Config& config);

/// The equations as LaTeX, the verdict as a comment before them.
[[nodiscard]] std::string bodies_latex(const ident::BodiesResult& result, const ident::BodiesRecord& record);

}  // namespace apps
