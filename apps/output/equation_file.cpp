#include "apps/output/equation_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/output/report_text.hpp"
#include "apps/output/run_json.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/csv_table.hpp"
#include "apps/text/json_parts.hpp"
#include "dsp/values/fault.hpp"
#include "dsp/values/signals.hpp"
#include "ident/judgement/judge.hpp"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

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

/// Null without a ranking: a method that does not weigh the rows as evidence.
Json models_json(const std::optional<ident::ModelRanking>& ranking, const std::vector<std::string>& terms) {
  if (!ranking) return {};
  Json result{{"num_scored", std::llround(ranking->num_models)}, {"all", ranking->all}};
  put(result, "odds_to_next", ranking->odds(), "no other model was scored");
  result["undecided"] = Json::array();
  for (Eigen::Index term = 0; term < ranking->inclusion.size(); ++term)
    if (ranking->is_undecided(term)) result["undecided"].push_back(terms[static_cast<std::size_t>(term)]);
  result["best"] = Json::array();
  for (const ident::RankedModel& model : ranking->best)
    result["best"].push_back(
        {{"terms", names_of(model.terms, terms)}, {"probability", model.probability}, {"nmse", model.rss}});
  return result;
}

Json cause_json(const ident::JudgedFit& fit) {
  return fit.judgement.cause ? Json(to_string(*fit.judgement.cause)) : Json();
}

/// What its coefficients are of.
Json stage_json(const ident::RangeResult& range, const ident::JudgedFit& fit) {
  Json row{{"name", fit.by_likelihood ? "likelihood" : "regression"}, {"sentence", printable(stage_text(range, fit))}};
  if (!fit.by_likelihood) return row;
  const ident::Likelihood& likelihood = range.likelihood;
  row["num_samples"] = std::llround(likelihood.num_samples);
  row["gain_of_process_noise"] = likelihood.gain_of_process_noise;
  row["unexplained_std"] = likelihood.unexplained_std;
  row["wanders"] = Json::array();
  for (const ident::Likelihood::Wander& wander : likelihood.wanders)
    row["wanders"].push_back({{"channel", wander.channel}, {"std_after_1_s", wander.std}, {"unit", wander.unit}});
  return row;
}

Json equation_row(const ident::RangeResult& range, const ident::JudgedFit& fit) {
  const std::vector<std::string>& terms = range.labels;
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
  row["stage"] = stage_json(range, fit);
  row["models"] = models_json(fit.fit.ranking, terms);
  row["sensors"] = Json::array();
  for (const ident::SensorEstimate& sensor : fit.sensors)
    row["sensors"].push_back({{"name", printable(sensor.name)},
                              {"unit", sensor.unit},
                              {"prior_std", sensor.prior_std},
                              {"mean", sensor.mean},
                              {"std", sensor.std}});
  row["coordinates"] = coordinates_json(fit.model.coordinates);
  row["extents"] = Json::object();
  for (const ident::Extent& extent : fit.model.extents) row["extents"][extent.signal] = {extent.lowest, extent.highest};
  row["ties"] = Json::array();
  for (const auto& [one, other] : fit.ties) row["ties"].push_back({printable(one), printable(other)});
  row["independent_fraction"] = fit.independent_fraction;
  row["covariance"] = matrix_json(fit.model.covariance);
  row["calibration"] = Json::array();
  for (const auto& [gain, std] : fit.model.calibration) row["calibration"].push_back({{"name", gain}, {"std", std}});
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

/// An equation and the range it is of.
struct EquationRow {
  std::string range;
  const Json* equation = nullptr;
};

/// The one that was asked for; what was not asked for is as the run chose it: the range, and in it the method whose
/// verdict the range has. Else the first.
std::optional<EquationRow> chosen(const Json& document, const std::string& range, const std::string& method) {
  std::optional<EquationRow> best;
  int best_rank = -1;
  for (const Json& candidate : document.at("ranges"))
    for (const Json& equation : candidate.at("methods")) {
      const std::string its_range = candidate.at("name"), its_method = equation.at("method");
      if ((!range.empty() && its_range != range) || (!method.empty() && its_method != method)) continue;
      const Json& choice = document.at("chosen");
      const int rank = 2 * (its_range == choice.at("range")) + (its_method == speaking_method(document, candidate));
      if (rank > best_rank) best = EquationRow{its_range, &equation}, best_rank = rank;
    }
  return best;
}

ident::Verdict verdict_of(const std::string& word, const fs::path& run) {
  if (const auto verdict = ident::verdict_from_string(word)) return *verdict;
  throw dsp::Fault(dsp::FaultKind::input, "run.damaged",
                   fmt::format("{}: the verdict is '{}', want describes, in_part, does_not or undecided",
                               (run / "equation.json").string(), printable(word)));
}

Eigen::MatrixXd matrix_of(const Json& rows, Eigen::Index size) {
  if (!rows.is_array() || static_cast<Eigen::Index>(rows.size()) != size) return {};
  Eigen::MatrixXd matrix(size, size);
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j < size; ++j)
      matrix(i, j) = rows.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(j)).get<double>();
  return matrix;
}

ident::Model model_of(const Json& row) {
  ident::Model model;
  model.target = row.at("target");
  model.target_unit = row.value("target_unit", std::string());
  std::vector<std::string> recordings;  // with coefficients of their own, in the order they are met
  for (const Json& term : row.at("terms")) {
    ident::ModelTerm one;
    one.name = term.at("name");
    one.unit = term.value("unit", "");
    if (one.recording_name = term.value("recording", ""); !one.recording_name.empty()) {
      auto at = std::find(recordings.begin(), recordings.end(), one.recording_name);
      if (at == recordings.end()) at = recordings.insert(at, one.recording_name);
      one.recording = static_cast<int>(at - recordings.begin()) + 1;
    }
    one.mean = term.at("mean");
    one.scale = term.contains("scale") && term.at("scale").is_number() ? term.at("scale").get<double>() : std::nan("");
    one.std = term.contains("std") && term.at("std").is_number() ? term.at("std").get<double>() : std::nan("");
    model.terms.push_back(std::move(one));
  }
  model.coordinates = coordinates_in(row.value("coordinates", Json::array()));
  const Json extents = row.value("extents", Json::object());
  for (const auto& [signal, extent] : extents.items()) model.extents.push_back({signal, extent.at(0), extent.at(1)});
  return model;
}

[[noreturn]] void refuse_choice(const Json& document, const fs::path& run, const std::string& range,
                                const std::string& method) {
  std::string known;
  for (const Json& one : document.at("ranges"))
    for (const Json& equation : one.at("methods"))
      known += fmt::format("{}{} by {}", known.empty() ? "" : ", ", one.at("name").get<std::string>(),
                           equation.at("method").get<std::string>());
  const std::string wanted = (range.empty() ? "" : fmt::format(" of range '{}'", range)) +
                             (method.empty() ? "" : fmt::format(" by '{}'", method));
  throw dsp::Fault(dsp::FaultKind::usage, "run.no_such_equation",
                   printable(fmt::format("{}: there is no equation{}; there are: {}", run.string(), wanted, known)));
}

/// Whether the motion of the base is among the signals of a run; earlier versions leave it to the columns of
/// prepared.csv.
bool base_measured(const Json& document, const fs::path& run) {
  if (document.contains("base_measured")) return document.at("base_measured").get<bool>();
  const std::string header = fmt::format(",{},", table_header(run / "prepared.csv"));
  const auto signals = dsp::signal_table();
  return std::any_of(signals.begin(), signals.end(), [&](const dsp::SignalInfo& signal) {
    return signal.body == dsp::Body::base && header.find(fmt::format(",{},", signal.name)) != std::string::npos;
  });
}

/// What `read` makes of the equation that was asked for, in its document.
template <class Read>
auto read_chosen(const fs::path& run, const std::string& range, const std::string& method, const Read& read) {
  const Json document = read_run_json(run / "equation.json");
  try {
    const std::optional<EquationRow> found = chosen(document, range, method);
    if (!found) refuse_choice(document, run, range, method);
    return read(document, *found);
  } catch (const Json::exception& error) {
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged",
                     fmt::format("{}: {}", (run / "equation.json").string(), error.what()));
  }
}

/// The coefficients' covariance; without one, the standard deviations alone.
Eigen::MatrixXd read_covariance(const Json& row, const ident::Model& model) {
  const auto size = std::ssize(model.terms);
  Eigen::MatrixXd covariance = matrix_of(row.value("covariance", Json()), size);
  if (covariance.size() > 0) return covariance;
  covariance = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index i = 0; i < size; ++i)
    if (const double std = model.terms[static_cast<std::size_t>(i)].std; std::isfinite(std))
      covariance(i, i) = std * std;
  return covariance;
}

/// Over the training rows; of folders of earlier versions, which have no extents, as far as x is a term; 0: not known.
double largest_x(const ident::Model& model) {
  for (const ident::Extent& extent : model.extents)
    if (extent.signal == "x") return std::max(std::abs(extent.lowest), std::abs(extent.highest));
  for (const ident::ModelTerm& term : model.terms)
    if (term.name == "x" && std::isfinite(term.scale)) return term.scale;
  return 0.0;
}

}  // namespace

Json term_json(const ident::ModelTerm& term, const ident::Fit& fit, std::string_view no_evidence) {
  Json result{{"name", term.name}};
  if (term.recording > 0) result["recording"] = printable(term.recording_name);
  result["mean"] = term.mean;
  put(result, "std", term.std, fit.no_variance);
  put(result, "std_noise", term.std_noise, fit.no_variance);
  for (const auto& [source, fraction] : term.budget) result["budget"][source] = fraction;
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

std::string equation_json(const std::vector<ident::RangeResult>& ranges, bool base_measured) {
  Json document = calibration_json(uncalibrated_channels(ranges));
  document["base_measured"] = base_measured;
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
    for (const ident::JudgedFit& fit : range.fits) row["methods"].push_back(equation_row(range, fit));
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

std::string speaking_method(const Json& equations, const Json& range) {
  const Json& chosen = equations.at("chosen");
  const Json of_run = chosen.is_object() ? chosen.at("method") : Json();
  const Json method = range.value("method", of_run);
  return method.is_string() ? method.get<std::string>() : "";
}

std::string label_of(const Json& term) {
  const std::string name = term.at("name"), recording = term.value("recording", "");
  return recording.empty() ? name : name + " in " + recording;
}

ident::IdentifiedEquation read_equation(const fs::path& run, const std::string& range, const std::string& method) {
  return read_chosen(run, range, method, [&](const Json& document, const EquationRow& found) {
    const Json& row = *found.equation;
    ident::IdentifiedEquation equation{.range = found.range,
                                       .method = row.at("method"),
                                       .target = row.at("target"),
                                       .text = row.at("text"),
                                       .verdict = verdict_of(row.at("verdict"), run),
                                       .terms = {},
                                       .mean = {},
                                       .covariance = {},
                                       .base_measured = base_measured(document, run)};
    for (const Json& gain : row.value("calibration", Json::array()))
      if (const std::string name = gain.at("name"); name == "displacements")
        equation.displacement_std = gain.at("std");
      else if (name == "f")
        equation.force_std = gain.at("std");
    ident::Model model = model_of(row);
    model.covariance = read_covariance(row, model);
    equation.coordinates = coordinates_sentence(model.coordinates);
    if (model.target_unit.starts_with("rad")) equation.x_unit = "rad";
    equation.largest_x = largest_x(model);
    model = equation_of(model, 0);
    equation.covariance = model.covariance;
    equation.mean.resize(std::ssize(model.terms));
    for (const ident::ModelTerm& term : model.terms) {
      const auto i = std::ssize(equation.terms);
      equation.mean[i] = term.mean;
      equation.terms.push_back(term.name);
    }
    return equation;
  });
}

PredictedEquation read_predicting_equation(const fs::path& run, const std::string& range, const std::string& method) {
  return read_chosen(run, range, method, [](const Json& document, const EquationRow& found) {
    PredictedEquation equation{found.range, model_of(*found.equation), {}};
    equation.model.covariance = read_covariance(*found.equation, equation.model);
    for (const Json& one : document.at("ranges"))
      if (one.at("name") == found.range && one.contains("linear")) equation.linear = model_of(one.at("linear"));
    return equation;
  });
}

}  // namespace apps
