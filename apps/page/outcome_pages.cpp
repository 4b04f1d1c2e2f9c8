#include "apps/page/outcome_pages.hpp"

#include <fmt/format.h>

#include "apps/output/study_output.hpp"
#include "apps/page/document.hpp"
#include "apps/page/page_sections.hpp"
#include "apps/process/printable.hpp"
#include "dsp/values/names.hpp"

namespace apps {

std::string response_page(const EquationResponse& result) {
  PlotFigure figure = response_figure(result);
  const std::string title = printable(figure.title, 200);
  figure.name = "frc";
  figure.zoomable = true;
  figure.panel_width_px *= 2.0;
  if (figure.panels.size() > 1)
    figure.panels.front().title = "amplitude of the payload, and of its motion relative to the base";
  return html_document(title, [&](HtmlWriter& html) {
    html.markup(page_figure(figure, false).markup);
    html.element("pre", printable_lines(response_text(result)));
  });
}

std::string study_page(const std::vector<StudyResult>& results, const std::vector<StudyAxis>& axes,
                       const std::vector<std::string>& ranges) {
  return html_document("How the identification depends on its settings", [&](HtmlWriter& html) {
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      PlotFigure figure = study_figure(results, axes, i);
      figure.name = "study-" + dsp::slug(ranges[i]);
      if (!figure.panels.empty()) html.markup(page_figure(figure, false).markup);
    }
    html.element("pre", printable_lines(study_text(results, axes)));
  });
}

}  // namespace apps
