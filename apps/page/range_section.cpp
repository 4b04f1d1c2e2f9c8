#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "apps/output/prediction.hpp"
#include "apps/output/report_text.hpp"
#include "apps/page/equation_display.hpp"
#include "apps/page/page.hpp"
#include "apps/page/page_sections.hpp"
#include "apps/page/physical_terms.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/number_text.hpp"
#include "apps/text/rounded.hpp"

namespace apps {
namespace {

using Strings = std::vector<std::string>;

std::string error_text(const ident::Figure& figure) {
  return figure.reason.empty() ? fmt::format("{:.3g}", figure.value) : "none: " + printable(figure.reason);
}

void write_coefficients(const ident::Model& model, HtmlWriter& html) {
  std::vector<Strings> rows;
  for (const ident::ModelTerm& term : model.terms)
    rows.push_back({label(term), with_uncertainty(term.mean, term.std), term.unit.empty() ? "-" : term.unit,
                    number_text(term.std), number_text(100.0 * term.coefficient_of_variation(), "{:.2g} %"),
                    number_text(term.inclusion_probability, "{:.3f}"), budget_text(model, term)});
  html.table("Coefficients",
             {"term", "coefficient", "unit", "standard deviation", "standard deviation / coefficient",
              "probability of belonging", "largest sources of uncertainty (share of the variance); calibration"},
             rows);
  if (const std::string sentence = calibration_sentence(model); !sentence.empty()) html.element("p", sentence);
}

void write_decisions(const ident::RangeResult& range, const ident::JudgedFit& fit, HtmlWriter& html) {
  std::vector<Strings> rows;
  for (const ident::RejectedTerm& term : fit.model.rejected)
    rows.push_back({term.name, number_text(term.inclusion_probability, "{:.3f}")});
  html.open("details").element("summary", "Candidates that were not kept, and remarks");
  if (!rows.empty()) html.table("Candidates that were not kept", {"term", "probability of belonging"}, rows);
  Strings open;
  for (const auto& [kept, other] : fit.ties) open.push_back(fmt::format("{} and {}", kept, other));
  if (fit.fit.ranking) {
    const ident::ModelRanking& ranking = *fit.fit.ranking;
    html.element("p", fmt::format("{:.0f} models were scored, {}; the first is {:.3g} times as probable as the next.",
                                  ranking.num_models, ranking.all ? "all there are" : "those near the kept terms",
                                  ranking.odds()));
  }
  if (!open.empty())
    html.element("p", fmt::format("Cannot be distinguished on these data: {}.", fmt::join(open, "; ")));
  for (const ident::DroppedTerm& term : range.dropped)
    html.element("p", fmt::format("Left out: {} ({})", term.name, term.reason));
  html.open("ul");
  for (const std::string& remark : fit.judgement.remarks) html.element("li", remark);
  html.close().close();
}

void write_methods(const ident::RangeResult& range, HtmlWriter& html) {
  std::vector<Strings> rows;
  for (const ident::JudgedFit& fit : range.fits)
    rows.push_back({std::string(to_string(fit.fit.method)),
                    fit.model.terms.empty() ? "none: " + std::string(in_words(fit.fit.status))
                                            : displayed_equation(fit.model, ident::Notation::text),
                    fit.model.terms.empty() ? "-" : in_words(fit.judgement.verdict),
                    error_text({fit.free_run.nmse_centred, fit.free_run.reason}), error_text(fit.test_centred)});
  html.table("All methods", {"method", "equation", "verdict", "free run NMSE", "test NMSE about the mean"}, rows);
}

void write_errors(const ident::JudgedFit& fit, HtmlWriter& html) {
  std::vector<Strings> rows{{"training", error_text(fit.train), error_text(fit.train_centred)},
                            {"test", error_text(fit.test), error_text(fit.test_centred)},
                            {"free run of x, test", error_text({fit.free_run.nmse, fit.free_run.reason}),
                             error_text({fit.free_run.nmse_centred, fit.free_run.reason})}};
  if (fit.recorded_run && !fit.free_run.reason.empty()) {  // what x was integrated of; rows are of the integral
    rows = {{"training, x integrated", rows[0][1], rows[0][2]},
            {"test, x integrated", rows[1][1], rows[1][2]},
            {fmt::format("{} as it was recorded, test, from where it is found to begin", fit.recorded_run->channel),
             "-", number_text(fit.recorded_run->nmse)}};
  }
  html.table(fmt::format("Errors as fractions of the power of the signal (NMSE). Noise of {}: {} {} rms",
                         fit.model.target, number_text(fit.model.noise_std), fit.model.target_unit),
             {"on", "NMSE", "about the mean"}, rows);
  if (!fit.bands_reason.empty()) return;
  const std::string_view fault = ident::fault_of(fit.bands);
  html.table(fmt::format("Predicted and actual spread: share of the test data inside the predicted bands{}",
                         fault.empty() ? "" : fmt::format(", which are {} here", fault)),
             {"band", "inside"},
             {{"50 %", fmt::format("{:.1f} %", 100.0 * fit.bands.within_50)},
              {"90 %", fmt::format("{:.1f} %", 100.0 * fit.bands.within_90)},
              {"95 %", fmt::format("{:.1f} %", 100.0 * fit.bands.within_95)}});
}

void write_equation(const ident::JudgedFit& fit, bool is_at_top, HtmlWriter& html) {
  if (!is_at_top) {
    html.element("p", fit.judgement.sentence);
    write_math(displayed_equation(fit.model, ident::Notation::mathml), html);
  }
  for (const std::string& sentence : own_coefficient_sentences(fit.model)) html.element("p", sentence);
  html.open("details").element("summary", "LaTeX and plain text, to copy");
  html.element("pre", displayed_equation(fit.model, ident::Notation::latex), {{"class", "copied"}});
  html.element("pre", displayed_equation(fit.model, ident::Notation::text), {{"class", "copied"}}).close();
}

void write_physics(const ident::RangeResult& range, const ident::JudgedFit& fit, const RunResults& results,
                   HtmlWriter& html) {
  std::vector<Strings> rows;
  for (const PhysicalTerm& term : physical_terms({&range, &fit}, results))
    rows.push_back({term.name, with_uncertainty(term.value, term.std), term.unit});
  if (!rows.empty()) html.table("Which means", {"quantity", "value", "unit"}, rows);
}

void write_prediction(const ident::RecordPrediction& prediction, HtmlWriter& html) {
  const std::string unit = prediction.unit.empty() ? "" : " " + prediction.unit;
  html.table(printable(prediction.recording, 200), {"of x", "value"},
             {{"free run, NMSE about the mean", error_text(prediction.nmse) + restarts_text(prediction)},
              {"a linear equation, likewise", error_text(prediction.linear)},
              {"a payload at rest, likewise", error_text(prediction.still)},
              {"rms error", error_text(prediction.rms) + unit},
              {"rms noise of the displacement", error_text(prediction.noise_floor) + unit}});
  if (!prediction.remark.empty()) html.element("p", printable(prediction.remark));
  std::vector<Strings> rows;
  for (const ident::CarryOver& one : prediction.coefficients)
    rows.push_back({one.term, with_uncertainty(one.identified, one.identified_std),
                    std::isfinite(one.here) ? with_uncertainty(one.here, one.here_std) : "not kept here",
                    !one.carries   ? "not known"
                    : *one.carries ? "carries over"
                                   : "does not carry over"});
  if (!rows.empty())
    html.table("Coefficients of the run and of this recording",
               {"term", "identified", "on this recording", "carries over?"}, rows);
}

}  // namespace

void write_agreement(const RunResults& results, HtmlWriter& html) {
  if (results.ranges.size() < 2) return;
  html.open("section", {{"id", "agreement"}}).element("h2", "Do the ranges agree?");
  const std::vector<ident::RangeDisagreement> pairs = ident::compare_ranges(results.ranges);
  if (pairs.empty()) html.element("p", "Yes: every coefficient of every range, within five standard deviations.");
  std::vector<Strings> rows;
  for (const ident::RangeDisagreement& pair : pairs)
    for (const ident::Disagreement& term : pair.terms)
      if (pair.method == pairs.front().method)  // the other methods' are in equation.json
        rows.push_back({fmt::format("{} and {}", pair.range_a, pair.range_b), term.sentence});
  if (!rows.empty()) {
    html.element(
        "p",
        "Not in every coefficient. A term that only one range has, or that changes its sign, does not describe both.");
    html.table(fmt::format("Disagreements beyond five standard deviations ({})", pairs.front().method),
               {"ranges", "what differs"}, rows);
  }
  html.close();
}

void write_predictions(const std::vector<ident::RecordPrediction>& predictions, const std::vector<PageFigure>& figures,
                       HtmlWriter& html) {
  if (predictions.empty()) return;
  html.open("section", {{"id", "others"}}).element("h2", "Other recordings");
  write_figures(figures, "prediction-", html);
  for (const ident::RecordPrediction& prediction : predictions) write_prediction(prediction, html);
  html.close();
}

void write_range(const ident::RangeResult& range, const RunResults& results, const std::vector<PageFigure>& figures,
                 bool folded, HtmlWriter& html) {
  const std::string id = fmt::format("range-{}", &range - results.ranges.data() + 1), prefix = id + "-";
  const bool is_chosen = chosen_equation(results.ranges).range == &range;
  html.open("section", {{"id", id}})
      .element("h2", fmt::format("Range {}{}", range.spec.name,
                                 is_chosen && results.ranges.size() > 1 ? ": the chosen equation" : ""));
  const ChosenEquation chosen = chosen_equation(range);
  if (folded)
    html.open("details", {{"class", "range"}})
        .element("summary", chosen.fit == nullptr
                                ? "no equation"
                                : fmt::format("{}: {}", in_words(chosen.fit->judgement.verdict),
                                              displayed_equation(chosen.fit->model, ident::Notation::text)));
  if (chosen.fit == nullptr) {
    html.element("p", "No method found an equation here.");
    write_methods(range, html);
  } else {
    write_equation(*chosen.fit, is_chosen, html);
    html.element("h3", "Does it follow the motion?");
    if (is_chosen) html.element("p", chosen.fit->judgement.sentence + " The figure is at the top.");
    write_figures(figures, prefix, Question::follows, is_chosen, html);
    write_errors(*chosen.fit, html);
    html.element("h3", "What is left over?");
    write_figures(figures, prefix, Question::left_over, false, html);
    html.element("h3", "What are the coefficients made of?");
    write_physics(range, *chosen.fit, results, html);
    write_coefficients(chosen.fit->model, html);
    write_figures(figures, prefix, Question::coefficients, false, html);
    html.element("h3", "How were the terms chosen?");
    html.element("p", fmt::format("Method: {}.", to_string(chosen.fit->fit.method)));
    write_methods(range, html);
    write_decisions(range, *chosen.fit, html);
    write_figures(figures, prefix, Question::choice, false, html);
    const bool has_figures = std::any_of(figures.begin(), figures.end(),
                                         [&](const PageFigure& figure) { return figure.name.starts_with(prefix); });
    if (!has_figures)
      html.element("p", fmt::format("Figures are drawn for the first {} ranges and for that of the chosen equation.",
                                    most_ranges_with_figures));
  }
  if (folded) html.close();
  html.close();
}

}  // namespace apps
