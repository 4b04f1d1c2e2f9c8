#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "apps/page/figures.hpp"
#include "apps/page/run_results.hpp"
#include "apps/text/html_writer.hpp"

// The parts of report.html below its first screen.

namespace apps {

/// A figure as a page has it, in the section that its name begins with.
struct PageFigure {
  std::string name, markup;
  bool is_wide = false;
  Question question = Question::none;
};

/// A figure with its caption, and a table of what is in it for those who do not see it. `has_files`: figures/NAME.svg
/// and .csv are beside the page.
[[nodiscard]] PageFigure page_figure(const PlotFigure& figure, bool has_files);

/// Those figures whose names begin so: wide ones below one another, then others beside one another. False: there are
/// none.
bool write_figures(const std::vector<PageFigure>& figures, std::string_view prefix, HtmlWriter& html);

/// Those of them that answer a question: the first, the others to be unfolded. `without_first`: it is shown elsewhere.
void write_figures(const std::vector<PageFigure>& figures, std::string_view prefix, Question question,
                   bool without_first, HtmlWriter& html);

/// An equation, as mathematics.
void write_math(const std::string& mathml, HtmlWriter& html);

/// A range: its equation, and by question what follows from it and what it is made of, with figures. The figure that
/// shows the chosen equation is at the top of the page.
void write_range(const ident::RangeResult& range, const RunResults& results, const std::vector<PageFigure>& figures,
                 bool folded, HtmlWriter& html);

/// What the equations of several ranges do not agree on; nothing of one range.
void write_agreement(const RunResults& results, HtmlWriter& html);

/// An equation on recordings that it was not fitted to, and their figures; nothing where there are none.
void write_predictions(const std::vector<ident::RecordPrediction>& predictions, const std::vector<PageFigure>& figures,
                       HtmlWriter& html);

/// The recordings: regimes, what is left out and why, response at the steps of a stepped sine.
void write_record(const RunResults& results, const std::vector<PageFigure>& figures, HtmlWriter& html);

/// The data sheet of the way from file to regression: filter, sensors, power balance, every check.
void write_front_end(const RunResults& results, const std::vector<PageFigure>& figures, HtmlWriter& html);

/// What the words and signs of the page mean.
void write_words(HtmlWriter& html);

/// What it takes to get the same page again.
void write_repeat(const Config& config, HtmlWriter& html);

}  // namespace apps
