#include "apps/output/metrics_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/output/equation_file.hpp"
#include "apps/output/report_text.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/json_number.hpp"
#include "apps/text/json_parts.hpp"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;

Json intervals_json(const std::vector<dsp::Interval>& intervals) {
  Json result = Json::array();
  for (const dsp::Interval& interval : intervals) result.push_back({interval.from_s, interval.to_s});
  return result;
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
  result["free_run_training_centred"] = number_or_null(fit.free_run.nmse_training);  // of one alone
  if (fit.recorded_run)  // about the mean, as the noise of the channel is
    result["recorded_run"] = {
        {"channel", fit.recorded_run->channel}, {"nmse", fit.recorded_run->nmse}, {"noise", fit.recorded_run->noise}};
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
  if (known) {
    const std::string_view fault = ident::fault_of(fit.bands);
    result["fault"] = fault.empty() ? Json() : Json(fault);
  }
  return result;
}

Json steps_json(const ident::JudgedFit& fit, const std::vector<std::string>& terms) {
  Json result = Json::array();
  for (const ident::FitStep& step : fit.fit.steps) {
    Json row{{"action", to_string(step.action)}};
    const auto name = [&](Eigen::Index term) { return terms[static_cast<std::size_t>(term)]; };
    row["term"] = step.term < 0 ? Json() : Json(name(step.term));
    if (step.term < 0) row["term_reason"] = "all terms at once";
    if (step.action == ident::FitAction::exchange) row["leaving"] = name(step.leaving);
    if (step.action == ident::FitAction::start) row["terms"] = names_of(step.terms, terms);
    if (std::isfinite(step.penalty)) row["lambda"] = step.penalty;
    put(row, "log_evidence", step.log_evidence, "not computed");
    put(row, "noise_variance", step.noise_variance, "not computed");
    result.push_back(std::move(row));
  }
  return result;
}

Json path_json(const ident::JudgedFit& fit, const std::vector<std::string>& terms) {
  Json result = Json::array();
  for (const ident::ModelOfSize& model : fit.path) {
    Json row{{"terms", names_of(model.terms, terms)}, {"left_over", model.left_over}};
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

Json fit_of(const Json& document, const std::string& range, const std::string& method) {
  for (const Json& candidate : document.at("ranges")) {
    if (candidate.at("name") != range) continue;
    const Json& methods = candidate.at("methods");
    for (const Json& fit : methods)
      if (fit.at("method") == method) return fit;
    return methods.empty() ? Json() : methods.front();
  }
  return {};
}

}  // namespace apps
