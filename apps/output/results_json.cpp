#include "apps/output/results_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/output/report_text.hpp"
#include "apps/process/printable.hpp"
#include "ident/validate/judge.hpp"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& document) {
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// A number, or null with the reason beside it.
void put(Json& object, const std::string& key, double value, std::string_view reason) {
  if (std::isfinite(value))
    object[key] = value;
  else {
    object[key] = nullptr;
    object[key + "_reason"] = reason;
  }
}

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
  result["steps"] = steps_json(fit, range.labels);
  result["path"] = path_json(fit, range.labels);
  return result;
}

Json check_json(const dsp::Check& check) {
  Json result{{"name", check.name}, {"channel", printable(check.channel)}, {"status", to_string(check.status)}};
  put(result, "value", check.value, "not a single number");
  put(result, "limit", check.limit, "there is none");
  result["message"] = printable(check.message);
  return result;
}

Json filter_json(const dsp::FilterSheet& sheet) {
  Json stages = Json::array();
  for (const dsp::FilterStage& stage : sheet.stages)
    stages.push_back({{"up", stage.up},
                      {"down", stage.down},
                      {"input_rate_hz", stage.input_rate_hz},
                      {"num_taps", stage.taps.size()}});
  Json result{{"stages", std::move(stages)}};
  put(result, "passband_ripple_db", sheet.passband_ripple_db, "not measured");
  put(result, "alias_rejection_db", sheet.alias_rejection_db, "nothing folds");
  put(result, "delay_removed_s", sheet.delay_s, "not measured");
  put(result, "edge_s", sheet.edge_s, "not measured");
  return result;
}

Json pair_json(const dsp::SensorRelation& relation) {
  Json result{{"name", relation.name}};
  const bool known = relation.reason.empty();
  put(result, "gain", known ? relation.sign * relation.gain : std::nan(""), relation.reason);
  put(result, "gain_std", known ? relation.gain_std : std::nan(""), relation.reason);
  put(result, "lag_s", known ? relation.lag_s : std::nan(""), relation.reason);
  put(result, "lag_std_s", known ? relation.lag_std_s : std::nan(""), relation.reason);
  result["highpass_hz"] = relation.highpass_hz;
  result["highpass_std_hz"] = relation.highpass_std_hz;
  put(result, "residual", known ? relation.residual : std::nan(""), relation.reason);
  return result;
}

Json power_json(const dsp::PowerCheck& power) {
  Json raw = Json::object(), corrected = Json::object();
  for (const dsp::RegimePower& one : power) {
    const std::string name(to_string(one.regime));
    put(raw, name, one.raw, "no such regime");
    put(corrected, name, one.corrected, "no such regime");
  }
  return {{"raw", std::move(raw)}, {"corrected", std::move(corrected)}};
}

Json segmentation_json(const dsp::Segmentation& segmentation) {
  const dsp::SegmentOptions& options = segmentation.options;
  Json result = Json::object();
  const bool found = segmentation.mount.has_value();
  const auto threshold = [&](const char* key, double value, const char* reason = "not used") {
    put(result, key, found ? value : std::nan(""), found ? reason : "regimes come from a file");
  };
  threshold("stick_speed_m_per_s", options.stick_speed_m_per_s);
  threshold("stick_duration_s", options.stick_duration_s);
  threshold("stick_halt_s", options.stick_halt_s);
  threshold("high_amplitude_m", options.high_amplitude_m > 0.0 ? options.high_amplitude_m : std::nan(""),
            "not given: branches are seen in the phase");
  result["remarks"] = segmentation.remarks;
  return result;
}

Json motion_json(const dsp::Prepared& recording) {
  Json result{{"recording", printable(recording.name)},
              {"rate_hz", recording.signals.sample_rate_hz},
              {"bus_rate_hz", recording.intermediate.sample_rate_hz},
              {"num_samples", recording.signals.num_samples()},
              {"edge_samples", recording.signals.edge_samples}};
  put(result, "dropped_power_fraction", recording.intermediate.dropped_power_fraction, "not computed");
  result["decimation"] = recording.decimation ? filter_json(*recording.decimation) : Json();
  if (!recording.decimation) result["decimation_reason"] = "the record stays at its own rate";
  return result;
}

Json channel_json(const dsp::Channel& channel) {
  return {{"name", printable(channel.name)},  {"role", to_string(channel.role)}, {"unit", printable(channel.unit)},
          {"calibrated", channel.calibrated}, {"delay_s", channel.delay_s},      {"highpass_hz", channel.highpass_hz}};
}

Json calibration_json(const std::vector<std::string>& uncalibrated) {
  Json result{{"calibrated", uncalibrated.empty()}};
  if (uncalibrated.empty()) return result;
  result["uncalibrated"] = Json::array();
  for (const std::string& channel : uncalibrated) result["uncalibrated"].push_back(printable(channel));
  return result;
}

Json cause_json(const ident::JudgedFit& fit) {
  return fit.judgement.cause ? Json(to_string(*fit.judgement.cause)) : Json();
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

/// The checks of all recordings, each with its recording.
Json recorded_checks(const std::vector<Input>& inputs) {
  Json result = Json::array();
  for (const Input& input : inputs)
    for (const dsp::Check& check : input.prepared.checks) {
      result.push_back(check_json(check));
      result.back()["recording"] = printable(input.prepared.name);
    }
  return result;
}

}  // namespace

std::string_view to_string(dsp::CheckStatus status) {
  constexpr std::string_view words[] = {"ok", "note", "warning", "failed"};
  return words[static_cast<int>(status)];
}

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
    Json row{
        {"name", printable(range.spec.name)}, {"verdict", nullptr}, {"cause", nullptr}, {"methods", Json::array()}};
    if (!range.fits.empty()) {
      const ident::JudgedFit& best = range.fits[ident::chosen_method(range)];
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

std::string quality_json(const std::vector<Input>& inputs) {
  std::vector<std::string> raw;
  for (const Input& input : inputs)
    for (const std::string& channel : input.prepared.signals.uncalibrated)
      raw.push_back(input.prepared.name + ": " + channel);
  Json document = calibration_json(raw);
  document["checks"] = recorded_checks(inputs);
  document["pairs"] = Json::array();
  document["power_check"] = nullptr;
  document["power_check_reason"] = "displacement and acceleration of one body were not both measured";
  document["motion"] = Json::array();
  for (const Input& input : inputs) {
    for (const dsp::SensorRelation& relation : input.prepared.relations)
      document["pairs"].push_back(pair_json(relation));
    document["motion"].push_back(motion_json(input.prepared));
    if (!input.segmentation.segments.empty())
      document["motion"].back()["segmentation"] = segmentation_json(input.segmentation);
    if (!input.power || !document["power_check"].is_null()) continue;
    document["power_check"] = power_json(*input.power);
    document["power_check_reason"] = nullptr;
  }
  return text_of(document);
}

std::string checks_json(const std::vector<Input>& inputs) {
  return text_of({{"checks", recorded_checks(inputs)}});
}

std::string fault_json(std::string_view name, std::string_view kind, int exit_code, std::string_view message,
                       std::string_view lines, const std::vector<dsp::Fault>& further) {
  Json error{{"name", name}, {"kind", kind}, {"exit_code", exit_code}, {"message", printable(message)}};
  if (!lines.empty()) error["lines"] = lines;
  for (const dsp::Fault& fault : further) {
    Json one{{"name", fault.name()}, {"message", printable(fault.what())}};
    if (!fault.lines().empty()) one["lines"] = fault.lines();
    error["further"].push_back(std::move(one));
  }
  return text_of({{"error", std::move(error)}});
}

std::string info_json(const std::vector<RecordingInfo>& recordings) {
  Json document{{"recordings", Json::array()}};
  for (const RecordingInfo& info : recordings) {
    Json row{{"file", printable(info.file)},
             {"container", info.container},
             {"rate_hz", info.sample_rate_hz},
             {"num_samples", info.num_samples},
             {"duration_s", static_cast<double>(info.num_samples) / info.sample_rate_hz}};
    row["sidecar"] = info.sidecar.empty() ? Json() : Json(printable(info.sidecar));
    row["channels"] = Json::array();
    for (const dsp::Channel& channel : info.channels) row["channels"].push_back(channel_json(channel));
    row["ranges"] = Json::array();
    for (const dsp::RangeSpec& range : info.ranges) {
      Json spec{{"name", printable(range.name)}, {"from_s", range.from_s}};
      put(spec, "to_s", range.to_s, "to the end");
      row["ranges"].push_back(std::move(spec));
    }
    row["bad"] = Json::array();
    for (const dsp::Interval& bad : info.bad)
      row["bad"].push_back({{"from_s", bad.from_s}, {"to_s", bad.to_s}, {"why", printable(bad.why)}});
    row["checks"] = Json::array();
    for (const dsp::Check& check : info.checks) row["checks"].push_back(check_json(check));
    document["recordings"].push_back(std::move(row));
  }
  return text_of(document);
}

std::string files_json(const std::vector<std::string>& files) {
  Json document{{"files", Json::array()}};
  for (const std::string& file : files) document["files"].push_back(printable(file));
  return text_of(document);
}

std::string terms_json(const std::vector<ident::FunctionHelp>& signals,
                       const std::vector<ident::FunctionHelp>& functions) {
  const auto list = [](const std::vector<ident::FunctionHelp>& entries) {
    Json result = Json::array();
    for (const ident::FunctionHelp& entry : entries)
      result.push_back({{"name", entry.name}, {"meaning", entry.meaning}});
    return result;
  };
  return text_of({{"signals", list(signals)}, {"functions", list(functions)}});
}

}  // namespace apps
