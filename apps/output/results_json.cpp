#include "apps/output/results_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/output/json_number.hpp"
#include "apps/output/json_parts.hpp"
#include "apps/output/report_text.hpp"
#include "apps/process/printable.hpp"
#include "ident/validate/judge.hpp"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;

using apps::put;
void put(Json& object, const std::string& key, const ident::Figure& figure) {
  put(object, key, figure.value, figure.reason);
}

Json intervals_json(const std::vector<dsp::Interval>& intervals) {
  Json result = Json::array();
  for (const dsp::Interval& interval : intervals) result.push_back({interval.from_s, interval.to_s});
  return result;
}

Json term_json(const ident::ModelTerm& term, const ident::Fit& fit, std::string_view no_evidence) {
  Json result{{"name", term.name}};
  if (term.recording > 0) result["recording"] = printable(term.recording_name);
  result["mean"] = term.mean;
  put(result, "std", term.std, fit.no_variance);
  put(result, "std_noise", term.std_noise, fit.no_variance);
  put(result, "std_robust", term.std_robust,
      !fit.no_variance.empty() ? fit.no_variance
      : term.budget.empty()    ? "too few rows"
                               : "the sensors' part of the standard deviation is in std");
  for (const auto& [source, fraction] : term.budget) result["budget"][source] = fraction;
  put(result, "std_si", term.std_si,
      !fit.no_variance.empty() ? fit.no_variance : "the channels' calibration is not known");
  for (const auto& [gain, exponent] : term.gain_exponents) result["gain_exponents"][gain] = exponent;
  put(result, "cov", term.coefficient_of_variation(), term.mean == 0.0 ? "the coefficient is zero" : fit.no_variance);
  result["unit"] = term.unit;
  result["scale"] = term.scale;
  result["mean_scaled"] = term.mean * term.scale;
  put(result, "std_scaled", term.std * term.scale, fit.no_variance);
  put(result, "t", term.t(), "the standard deviation is zero or unknown");
  put(result, "evidence_gain", term.evidence_gain, no_evidence);
  put(result, "inclusion_probability", term.inclusion_probability, no_evidence);
  return result;
}

/// Rows of a matrix; null where an entry is not finite or there is none.
Json matrix_json(const Eigen::MatrixXd& matrix) {
  if (matrix.size() == 0 || !matrix.allFinite()) return {};
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    rows.push_back(Json::array());
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) rows.back().push_back(matrix(i, j));
  }
  return rows;
}

Json nmse_json(const ident::JudgedFit& fit) {
  Json result = Json::object();
  put(result, "train", fit.train);
  put(result, "test", fit.test);
  put(result, "train_centred", fit.train_centred);
  put(result, "test_centred", fit.test_centred);
  const bool ran = fit.free_run.reason.empty();
  result["free_run"] = ran ? Json(fit.free_run.nmse) : Json();
  result["free_run_centred"] =
      ran && std::isfinite(fit.free_run.nmse_centred) ? Json(fit.free_run.nmse_centred) : Json();
  result["free_run_training_centred"] = number_or_null(fit.free_run.nmse_training);     // of one alone
  result["free_run_within_intervals"] = number_or_null(fit.free_run.larger_closest());  // where x is missed
  result["free_run_reason"] = fit.free_run.reason.empty() ? Json() : Json(fit.free_run.reason);
  return result;
}

/// A calibrated model has them near their names.
Json bands_json(const ident::JudgedFit& fit) {
  Json result = Json::object();
  const bool known = fit.bands_reason.empty();
  for (const auto& [name, fraction] : {std::pair{"within_50", fit.bands.within_50},
                                       {"within_90", fit.bands.within_90},
                                       {"within_95", fit.bands.within_95}})
    put(result, name, known ? fraction : std::nan(""), fit.bands_reason);
  return result;
}

Json steps_json(const ident::JudgedFit& fit, const std::vector<std::string>& terms) {
  Json result = Json::array();
  for (const ident::FitStep& step : fit.fit.steps) {
    Json row{{"action", to_string(step.action)}};
    const auto name = [&](Eigen::Index term) { return Json(terms[static_cast<std::size_t>(term)]); };
    row["term"] = step.term < 0 ? Json() : name(step.term);
    if (step.term < 0) row["term_reason"] = "all terms at once";
    if (step.action == ident::FitAction::exchange) row["leaving"] = name(step.leaving);
    if (step.action == ident::FitAction::start) {
      row["terms"] = Json::array();
      for (const Eigen::Index term : step.terms) row["terms"].push_back(name(term));
    }
    if (std::isfinite(step.penalty)) row["lambda"] = step.penalty;
    put(row, "log_evidence", step.log_evidence, "not computed");
    put(row, "noise_variance", step.noise_variance, "not computed");
    result.push_back(std::move(row));
  }
  return result;
}

/// Null without a ranking: a method that does not weigh the rows as evidence.
Json models_json(const std::optional<ident::ModelRanking>& ranking, const std::vector<std::string>& terms) {
  if (!ranking) return {};
  const auto name = [&](Eigen::Index term) { return terms[static_cast<std::size_t>(term)]; };
  Json result{{"num_scored", std::llround(ranking->num_models)}, {"all", ranking->all}};
  put(result, "odds_to_next", ranking->odds(), "no other model was scored");
  result["undecided"] = Json::array();
  for (Eigen::Index term = 0; term < ranking->inclusion.size(); ++term)
    if (ranking->is_undecided(term)) result["undecided"].push_back(name(term));
  result["best"] = Json::array();
  for (const ident::RankedModel& model : ranking->best) {
    Json row{{"terms", Json::array()}, {"probability", model.probability}, {"nmse", model.rss}};
    for (const Eigen::Index term : model.terms) row["terms"].push_back(name(term));
    result["best"].push_back(std::move(row));
  }
  return result;
}

Json path_json(const ident::JudgedFit& fit, const std::vector<std::string>& terms) {
  Json result = Json::array();
  for (const ident::ModelOfSize& model : fit.path) {
    Json row{{"terms", Json::array()}, {"left_over", model.left_over}};
    for (const Eigen::Index term : model.terms) row["terms"].push_back(terms[static_cast<std::size_t>(term)]);
    put(row, "num_effective", model.terms.empty() ? std::nan("") : model.num_effective, "no term");
    result.push_back(std::move(row));
  }
  return result;
}

Json method_json(const ident::JudgedFit& fit, const ident::RangeResult& range, const ident::IdentifyOptions& options) {
  const std::string no_evidence = std::string(to_string(fit.fit.method)) + " computes no evidence";
  const bool has_evidence = std::isfinite(fit.fit.log_evidence);
  Json result{{"method", to_string(fit.fit.method)}};
  result["selection"] = has_evidence ? Json(to_string(*fit.fit.selection)) : Json();
  if (!has_evidence) result["selection_reason"] = no_evidence;
  put(result, "tau", has_evidence ? fit.fit.tau : std::nan(""), no_evidence);
  result["status"] = to_string(fit.fit.status);
  result["iterations"] = fit.fit.iterations;
  result["discarded_iterations"] = fit.fit.discarded_iterations;
  result["target"] = options.target;
  result["terms"] = Json::array();
  for (const ident::ModelTerm& term : fit.model.terms) result["terms"].push_back(term_json(term, fit.fit, no_evidence));
  put(result, "noise_std", fit.model.noise_std, fit.fit.no_variance);
  put(result, "log_evidence", fit.fit.log_evidence, no_evidence);
  put(result, "condition_number", fit.fit.condition_number, "no term was selected");
  put(result, "residual_whiteness", fit.whiteness.tested ? fit.whiteness.p_value : std::nan(""),
      "too few rows, or no residual");
  result["residual_white"] = fit.whiteness.tested ? Json(fit.whiteness.white) : Json();
  put(result, "residual_peak_share", fit.whiteness.tested ? fit.whiteness.peak_fraction : std::nan(""),
      "too few rows, or no residual");
  result["num_effective"] = fit.size.num_effective();
  result["structural_fraction"] = fit.size.structural_fraction;
  result["noise_autoregression"] = fit.size.autoregression;
  result["nmse"] = nmse_json(fit);
  result["bands"] = bands_json(fit);
  result["free_run_stretches"] = fit.free_run.num_ranges;
  result["free_run_restarts"] = fit.free_run.num_restarts;
  result["free_runs"] = Json::array();  // each from its measured state
  for (const ident::FreeRunStart& start : fit.free_run.starts)
    result["free_runs"].push_back({{"recording", start.recording + 1}, {"from_s", start.time_s}, {"to_s", start.to_s}});
  result["steps"] = steps_json(fit, range.labels);
  result["path"] = path_json(fit, range.labels);
  return result;
}

Json cause_json(const ident::JudgedFit& fit) {
  return fit.judgement.cause ? Json(to_string(*fit.judgement.cause)) : Json();
}

/// x of the equation is the displacement as recorded less `zero`, f what was recorded `lead_s` later.
Json coordinates_json(const ident::Model& model) {
  Json rows = Json::array();
  for (const ident::Coordinates& one : model.coordinates)
    rows.push_back({{"recording", printable(one.recording)},
                    {"zero", one.zero},
                    {"zero_std", one.zero_std},
                    {"prepared_zero", one.prepared_zero},
                    {"lead_s", one.lead_s},
                    {"lead_std_s", one.lead_std_s}});
  return rows;
}

Json equation_row(const ident::JudgedFit& fit, const std::vector<std::string>& terms) {
  const std::string method(to_string(fit.fit.method));
  Json row{{"method", method},
           {"target", fit.model.target},
           {"target_unit", fit.model.target_unit},
           {"text", ident::to_text(fit.model)},
           {"latex", ident::to_latex(fit.model)},
           {"verdict", to_string(fit.judgement.verdict)},
           {"cause", cause_json(fit)},
           {"sentence", printable(fit.judgement.sentence)},
           {"remarks", Json::array()},
           {"terms", Json::array()}};
  for (const std::string& remark : fit.judgement.remarks) row["remarks"].push_back(printable(remark));
  for (const ident::ModelTerm& term : fit.model.terms)
    row["terms"].push_back(term_json(term, fit.fit, method + " computes no evidence"));
  row["rejected"] = Json::array();
  for (const ident::RejectedTerm& term : fit.model.rejected)
    row["rejected"].push_back({{"name", term.name}, {"inclusion_probability", term.inclusion_probability}});
  row["models"] = models_json(fit.fit.ranking, terms);
  row["sensors"] = Json::array();
  for (const ident::SensorEstimate& sensor : fit.sensors)
    row["sensors"].push_back({{"name", printable(sensor.name)},
                              {"unit", sensor.unit},
                              {"prior_std", sensor.prior_std},
                              {"mean", sensor.mean},
                              {"std", sensor.std}});
  row["coordinates"] = coordinates_json(fit.model);
  row["ties"] = Json::array();
  for (const auto& [one, other] : fit.ties) row["ties"].push_back({printable(one), printable(other)});
  row["independent_fraction"] = fit.independent_fraction;
  row["covariance"] = matrix_json(fit.model.covariance);
  row["covariance_robust"] = matrix_json(fit.model.covariance_robust);
  return row;
}

/// What the equations of a range must beat.
Json linear_json(const ident::Model& linear) {
  Json row{{"target", linear.target}, {"target_unit", linear.target_unit}, {"terms", Json::array()}};
  for (const ident::ModelTerm& term : linear.terms) {
    Json one{{"name", term.name}};
    if (term.recording > 0) one["recording"] = printable(term.recording_name);
    one["mean"] = term.mean;
    one["unit"] = term.unit;
    row["terms"].push_back(std::move(one));
  }
  return row;
}

}  // namespace

std::string metrics_json(const std::vector<ident::RangeResult>& ranges, const ident::IdentifyOptions& options) {
  Json document = calibration_json(uncalibrated_channels(ranges));
  document["ranges"] = Json::array();
  for (const ident::RangeResult& range : ranges) {
    Json row{{"name", printable(range.spec.name)}, {"regime", range.regime.any() ? Json() : Json(range.regime.name())}};
    if (range.regime.any()) row["regime_reason"] = "the range is given by time, not by regime";
    row["train_s"] = intervals_json(range.rows.train_s);
    row["test_s"] = intervals_json(range.rows.test_s);
    row["num_train"] = range.rows.train.size();
    row["num_test"] = range.rows.test.size();
    row["where"] = range.spec.where;
    row["left_out"] = Json::array();
    for (const ident::DroppedTerm& term : range.dropped)
      row["left_out"].push_back({{"name", term.name}, {"reason", term.reason}});
    row["methods"] = Json::array();
    for (const ident::JudgedFit& fit : range.fits) row["methods"].push_back(method_json(fit, range, options));
    document["ranges"].push_back(std::move(row));
  }
  return text_of(document);
}

std::string equation_json(const std::vector<ident::RangeResult>& ranges) {
  Json document = calibration_json(uncalibrated_channels(ranges));
  const std::optional<ident::ChosenFit> chosen = ident::chosen_fit(ranges);
  document["chosen"] = nullptr;
  if (chosen)
    document["chosen"] = {{"range", printable(ranges[chosen->range].spec.name)},
                          {"method", to_string(ranges[chosen->range].fits[chosen->method].fit.method)}};
  document["ranges"] = document["disagreements"] = Json::array();
  for (const ident::RangeResult& range : ranges) {
    Json row{{"name", printable(range.spec.name)},
             {"method", nullptr},
             {"verdict", nullptr},
             {"cause", nullptr},
             {"methods", Json::array()}};
    if (!range.fits.empty()) {
      const ident::JudgedFit& best = range.fits[ident::chosen_method(range)];
      row["method"] = to_string(best.fit.method);
      row["verdict"] = to_string(best.judgement.verdict);
      row["cause"] = cause_json(best);
    }
    for (const ident::JudgedFit& fit : range.fits) row["methods"].push_back(equation_row(fit, range.labels));
    row["linear"] = linear_json(range.linear);
    document["ranges"].push_back(std::move(row));
  }
  for (const ident::RangeDisagreement& pair : ident::compare_ranges(ranges)) {
    Json row{{"method", pair.method},
             {"ranges", {printable(pair.range_a), printable(pair.range_b)}},
             {"terms", Json::array()}};
    for (const ident::Disagreement& term : pair.terms)
      row["terms"].push_back({{"name", term.term}, {"sentence", printable(term.sentence)}});
    document["disagreements"].push_back(std::move(row));
  }
  return text_of(document);
}

}  // namespace apps
