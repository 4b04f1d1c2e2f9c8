#include "apps/output/study_output.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/output/tables.hpp"
#include "apps/text/json_number.hpp"
#include "apps/text/number_text.hpp"
#include "dsp/values/constants.hpp"

namespace apps {
namespace {

using nlohmann::ordered_json;

using dsp::nan;

double value_of(const ident::Figure& figure) {
  return figure.reason.empty() ? figure.value : nan;
}

std::string kept(const ident::JudgedFit& fit) {
  std::vector<std::string> names;
  for (const ident::ModelTerm& term : fit.model.terms) names.push_back(label(term));
  return fmt::format("{}", fmt::join(names, " "));
}

/// Every fit of a cell with its range.
template <class Use>
void for_each_fit(const StudyResult& result, Use&& use) {
  for (const StudyRange& range : result.ranges)
    for (const ident::JudgedFit& fit : range.fits) use(range, fit);
}

/// What one term was through the study.
struct Persistence {
  std::string term;
  int kept = 0;
  double least = HUGE_VAL, greatest = -HUGE_VAL;
};

/// All fits of one range by one method.
struct Series {
  std::string range, method;
  std::size_t num_fits = 0;
  std::vector<Persistence> terms = {};  ///< in the order of the largest library
};

void add_fit(Series& series, const StudyRange& range, const ident::JudgedFit& fit) {
  ++series.num_fits;
  for (const std::string& name : range.terms) {
    auto at = std::find_if(series.terms.begin(), series.terms.end(),
                           [&](const Persistence& term) { return term.term == name; });
    if (at == series.terms.end()) at = series.terms.insert(at, {name});
    bool is_kept = false;
    for (const ident::ModelTerm& term : fit.model.terms) {
      if (term.name != name) continue;
      is_kept = true;  // one of each recording counts once
      at->least = std::min(at->least, term.mean);
      at->greatest = std::max(at->greatest, term.mean);
    }
    at->kept += is_kept;
  }
}

std::vector<Series> series_of(const std::vector<StudyResult>& results) {
  std::vector<Series> all;
  for (const StudyResult& result : results)
    for_each_fit(result, [&](const StudyRange& range, const ident::JudgedFit& fit) {
      const auto method = to_string(fit.fit.method);
      auto at = std::find_if(all.begin(), all.end(),
                             [&](const Series& s) { return s.range == range.name && s.method == method; });
      if (at == all.end()) at = all.insert(at, {range.name, std::string(method)});
      add_fit(*at, range, fit);
    });
  return all;
}

std::string persistence_text(const Series& series) {
  std::string text = fmt::format("{}, {}: kept in how many of {} settings, and between which coefficients\n",
                                 series.range, series.method, series.num_fits);
  for (const Persistence& term : series.terms) {
    if (term.kept == 0) continue;
    text += fmt::format("  {:<12} {:>4}  {:.4g} to {:.4g}{}\n", term.term, term.kept, term.least, term.greatest,
                        term.least * term.greatest < 0.0 ? ", changes sign" : "");
  }
  return text;
}

std::string best_cutoff_text(const std::vector<StudyResult>& results, int best) {
  const StudyResult& result = results[static_cast<std::size_t>(best)];
  std::string text = fmt::format("best cut-off: {}\n", result.cell.label());
  for (const StudyRange& range : result.ranges)
    if (!range.fits.empty()) text += fmt::format("  {}: {}\n", range.name, range.fits.front().judgement.sentence);
  return text;
}

/// The fits that a figure shows of cells: by the first method of each, null where it has none.
std::vector<const ident::JudgedFit*> shown_fits(const std::vector<const StudyResult*>& cells, std::size_t range) {
  std::vector<const ident::JudgedFit*> fits;
  for (const StudyResult* cell : cells) {
    const bool has_fit = range < cell->ranges.size() && !cell->ranges[range].fits.empty();
    fits.push_back(has_fit ? &cell->ranges[range].fits.front() : nullptr);
  }
  return fits;
}

std::pair<double, double> places(std::size_t count) {
  return {-0.5, static_cast<double>(count) - 0.5};
}

PlotPanel errors_panel(const std::vector<const ident::JudgedFit*>& fits, const std::string& title,
                       const std::vector<std::string>& names) {
  PlotPanel panel{title, "", "log10 NMSE", {}, places(fits.size()), {}, names, {}};
  double low = 0.0, high = -12.0;
  const auto add = [&](const char* label, PlotColour colour, auto&& nmse_of) {
    std::vector<double> x, y;
    for (const ident::JudgedFit* fit : fits) {
      const double nmse = fit == nullptr ? nan : nmse_of(*fit);
      x.push_back(static_cast<double>(x.size()));
      y.push_back(nmse > 0.0 ? std::log10(nmse) : nan);
      if (std::isfinite(y.back())) low = std::min(low, y.back()), high = std::max(high, y.back());
    }
    panel.series.push_back(plot_series(label, x, y, PlotStyle::line, colour));
    panel.series.push_back(plot_series("", x, y, PlotStyle::points, colour));
  };
  add("train", PlotColour::black, [](const ident::JudgedFit& fit) { return value_of(fit.train); });
  add("test", PlotColour::vermilion, [](const ident::JudgedFit& fit) { return value_of(fit.test); });
  add("free run", PlotColour::blue, [](const ident::JudgedFit& fit) { return fit.free_run.nmse; });
  panel.y_limits = {low - 0.3, std::max(high, low) + 0.3 + 0.35 * (std::max(high, low) - low + 1.0)};
  return panel;
}

PlotPanel terms_panel(const std::vector<const ident::JudgedFit*>& fits, const std::vector<std::string>& terms,
                      const std::vector<std::string>& names) {
  PlotPanel panel{"terms kept", "", "", {}, places(fits.size()), places(terms.size()), names, terms};
  for (const bool positive : {true, false}) {
    std::vector<double> x, y;
    for (std::size_t i = 0; i < fits.size(); ++i) {
      if (fits[i] == nullptr) continue;
      for (const ident::ModelTerm& term : fits[i]->model.terms)
        if ((term.mean > 0.0) == positive) {
          x.push_back(static_cast<double>(i));
          y.push_back(static_cast<double>(std::find(terms.begin(), terms.end(), term.name) - terms.begin()));
        }
    }
    panel.series.push_back(
        plot_series("", x, y, PlotStyle::points, positive ? PlotColour::vermilion : PlotColour::blue));
  }
  return panel;
}

}  // namespace

std::string study_text(const std::vector<StudyResult>& results, const std::vector<StudyAxis>& axes) {
  std::string text;
  for (const StudyAxis& axis : axes) text += fmt::format("{}: {}\n", axis.key, fmt::join(axis.values, ", "));
  std::size_t width = 8;
  for (const StudyResult& result : results) width = std::max(width, result.cell.label().size());
  constexpr const char* row = "{:<{}}  {:<8} {:<9} {:>5} {:>9} {:>9} {:>9}  {}\n";
  text += "\n" + fmt::format(fmt::runtime(row), "setting", width, "range", "method", "terms", "train", "test",
                             "free run", "kept");
  for (const StudyResult& result : results) {
    if (!result.trouble.empty()) text += fmt::format("{:<{}}  {}\n", result.cell.label(), width, result.trouble);
    for_each_fit(result, [&](const StudyRange& range, const ident::JudgedFit& fit) {
      text += fmt::format(fmt::runtime(row), result.cell.label(), width, range.name, to_string(fit.fit.method),
                          fit.model.terms.size(), three_digits(value_of(fit.train)), three_digits(value_of(fit.test)),
                          three_digits(fit.free_run.nmse), kept(fit));
    });
  }
  if (const int best = best_cutoff(results); best >= 0) text += "\n" + best_cutoff_text(results, best);
  for (const Series& series : series_of(results)) text += "\n" + persistence_text(series);
  return text;
}

std::string study_csv(const std::vector<StudyResult>& results) {
  const auto cell = [](double value) { return number_text(value, "{:.17g}", ""); };
  std::string text = "setting,range,method,num_terms,nmse_train,nmse_test,nmse_free_run,terms\n";
  for (const StudyResult& result : results)
    for_each_fit(result, [&](const StudyRange& range, const ident::JudgedFit& fit) {
      text += fmt::format("{},{},{},{},{},{},{},{}\n", text_cell(result.cell.label()), text_cell(range.name),
                          to_string(fit.fit.method), fit.model.terms.size(), cell(value_of(fit.train)),
                          cell(value_of(fit.test)), cell(fit.free_run.nmse), text_cell(kept(fit)));
    });
  return text;
}

std::string study_json(const std::vector<StudyResult>& results, const std::vector<StudyAxis>& axes) {
  ordered_json document{{"axes", ordered_json::array()}, {"cells", ordered_json::array()}};
  for (const StudyAxis& axis : axes) document["axes"].push_back({{"key", axis.key}, {"values", axis.values}});
  ordered_json& cells = document["cells"];
  for (const StudyResult& result : results) {
    ordered_json setting = ordered_json::object();
    for (const auto& [key, value] : result.cell.setting) setting[key] = value;
    if (!result.trouble.empty())
      cells.push_back({{"setting", setting}, {"range", nullptr}, {"reason", result.trouble}});
    for_each_fit(result, [&](const StudyRange& range, const ident::JudgedFit& fit) {
      const std::string& reason = fit.free_run.reason;
      cells.push_back({{"setting", setting},
                       {"range", range.name},
                       {"method", to_string(fit.fit.method)},
                       {"status", to_string(fit.fit.status)},
                       {"tau", number_or_null(fit.fit.tau)},
                       {"num_train", range.num_train},
                       {"num_test", range.num_test},
                       {"nmse",
                        {{"train", number_or_null(value_of(fit.train))},
                         {"test", number_or_null(value_of(fit.test))},
                         {"free_run", number_or_null(fit.free_run.nmse)},
                         {"free_run_reason", reason.empty() ? ordered_json() : ordered_json(reason)}}},
                       {"terms", ordered_json::array()}});
      for (const ident::ModelTerm& term : fit.model.terms)
        cells.back()["terms"].push_back(
            {{"name", term.name}, {"mean", term.mean}, {"std", number_or_null(term.std)}, {"unit", term.unit}});
    });
  }
  const int best = best_cutoff(results);
  document["best_cutoff"] =
      best < 0 ? ordered_json() : ordered_json(results[static_cast<std::size_t>(best)].cell.label());
  return document.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

PlotFigure study_figure(const std::vector<StudyResult>& results, const std::vector<StudyAxis>& axes,
                        std::size_t range) {
  PlotFigure figure;
  std::string name;
  std::vector<std::string> terms;
  for (const StudyResult& result : results) {
    if (range >= result.ranges.size()) continue;
    name = result.ranges[range].name;
    for (const std::string& term : result.ranges[range].terms)
      if (std::find(terms.begin(), terms.end(), term) == terms.end()) terms.push_back(term);
  }
  figure.title = fmt::format("Range {}: errors and terms", name);
  figure.panel_height_px = std::max(300.0, 110.0 + 15.0 * static_cast<double>(terms.size()));
  const bool grid = std::none_of(results.begin(), results.end(), [](const auto& one) { return one.cell.axis >= 0; });
  for (int axis = grid ? -1 : 0; axis < (grid ? 0 : static_cast<int>(axes.size())); ++axis) {
    std::vector<const StudyResult*> cells;
    std::vector<std::string> names;
    for (const StudyResult& result : results) {
      if (result.cell.axis != axis) continue;
      cells.push_back(&result);
      names.push_back(grid ? fmt::format("{}", cells.size()) : result.cell.setting.front().second);
      if (grid) figure.caption.push_back(fmt::format("{}: {}", cells.size(), result.cell.label()));
    }
    const std::vector<const ident::JudgedFit*> fits = shown_fits(cells, range);
    std::string method;
    for (const ident::JudgedFit* fit : fits)
      if (fit != nullptr) method = to_string(fit->fit.method);
    const std::string title =
        fmt::format("{}, {}", grid ? "settings" : axes[static_cast<std::size_t>(axis)].key, method);
    figure.panels.push_back(errors_panel(fits, title, names));
    figure.panels.push_back(terms_panel(fits, terms, names));
  }
  figure.caption.push_back("Dots: terms kept, with a positive (vermilion) or a negative (blue) coefficient.");
  return figure;
}

}  // namespace apps
