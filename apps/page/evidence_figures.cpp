#include "apps/page/evidence_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace apps {
namespace {

/// Of searches that go from model to model.
std::optional<PlotFigure> evidence_figure(const ident::JudgedFit& fit, const std::string& slug) {
  std::vector<double> moves, evidence;
  for (std::size_t i = 0; i < fit.fit.steps.size(); ++i)
    if (const double value = fit.fit.steps[i].log_evidence; std::isfinite(value)) {
      moves.push_back(static_cast<double>(i));
      evidence.push_back(value);
    }
  if (moves.size() < 2) return {};
  return chart(slug + "-evidence", "Log evidence after each move of the search. It rises while terms are worth adding.",
               {"evidence path",
                "move",
                "log evidence",
                {plot_series("log evidence", moves, evidence, PlotStyle::line, PlotColour::black)}});
}

/// Of the default selection: what the best model of each number of terms leaves, and which was kept.
std::optional<PlotFigure> path_figure(const ident::JudgedFit& fit, const std::string& slug) {
  constexpr double least = 1e-24;  // rounding
  std::vector<double> sizes, left_db, kept, kept_db;
  for (const ident::ModelOfSize& model : fit.path) {
    sizes.push_back(static_cast<double>(model.terms.size()));
    left_db.push_back(10.0 * std::log10(std::max(least, model.left_over)));
    if (model.terms.size() == fit.model.terms.size()) kept.push_back(sizes.back()), kept_db.push_back(left_db.back());
  }
  if (sizes.size() < 2) return {};
  PlotPanel panel{"error against the number of terms",
                  "number of terms",
                  fmt::format("power left of {} (dB)", fit.model.target),
                  {plot_series("best of each size", sizes, left_db, PlotStyle::line, PlotColour::black)}};
  if (!kept.empty())
    panel.series.push_back(plot_series("kept", kept, kept_db, PlotStyle::points, PlotColour::vermilion));
  return cloud(slug + "-terms",
               "What the best equation of each number of terms leaves of the target. The curve falls steeply as "
               "long as terms describe the motion, and flattens where further ones describe the noise.",
               std::move(panel));
}

}  // namespace

void evidence_figures(const ident::JudgedFit& fit, const std::string& slug, const FigureTaker& take) {
  for (std::optional<PlotFigure> figure : {evidence_figure(fit, slug), path_figure(fit, slug)})
    if (figure) take(std::move(*figure));
}

}  // namespace apps
