#include "apps/output/identified_equation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/output/csv_table.hpp"
#include "apps/output/run_json.hpp"
#include "apps/process/printable.hpp"
#include "dsp/fault.hpp"
#include "dsp/signals.hpp"

namespace apps {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// An equation and the range it is of.
struct Row {
  std::string range;
  const Json* equation = nullptr;
};

/// The one that was asked for; what was not asked for is as the run chose it: the range, and in it the method whose
/// verdict the range has. Else the first.
std::optional<Row> chosen(const Json& document, const std::string& range, const std::string& method) {
  std::optional<Row> best;
  int best_rank = -1;
  for (const Json& candidate : document.at("ranges"))
    for (const Json& equation : candidate.at("methods")) {
      const std::string its_range = candidate.at("name"), its_method = equation.at("method");
      if ((!range.empty() && its_range != range) || (!method.empty() && its_method != method)) continue;
      const Json& choice = document.at("chosen");
      const int rank = 2 * (its_range == choice.at("range")) + (its_method == speaking_method(document, candidate));
      if (rank > best_rank) best = Row{its_range, &equation}, best_rank = rank;
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
    one.scale = term.contains("scale") && term.at("scale").is_number() ? term.at("scale").get<double>() : nan;
    one.std = term.contains("std") && term.at("std").is_number() ? term.at("std").get<double>() : nan;
    model.terms.push_back(std::move(one));
  }
  for (const Json& one : row.value("coordinates", Json::array()))
    model.coordinates.push_back({.recording = one.at("recording"),
                                 .zero = one.at("zero"),
                                 .zero_std = one.at("zero_std"),
                                 .prepared_zero = one.at("prepared_zero"),
                                 .lead_s = one.at("lead_s"),
                                 .lead_std_s = one.at("lead_std_s")});
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

/// Whether prepared.csv has a column of the base.
bool has_base(const fs::path& run) {
  const std::string header = fmt::format(",{},", table_header(run, "prepared.csv"));
  const auto signals = dsp::signal_table();
  return std::any_of(signals.begin(), signals.end(), [&](const dsp::SignalInfo& signal) {
    return signal.body == dsp::Body::base && header.find(fmt::format(",{},", signal.name)) != std::string::npos;
  });
}

}  // namespace

ident::IdentifiedEquation read_equation(const fs::path& run, const std::string& range, const std::string& method) {
  const Json document = read_run_json(run / "equation.json");
  try {
    const std::optional<Row> found = chosen(document, range, method);
    if (!found) refuse_choice(document, run, range, method);
    const Json& row = *found->equation;
    ident::IdentifiedEquation equation{.range = found->range,
                                       .method = row.at("method"),
                                       .target = row.at("target"),
                                       .text = row.at("text"),
                                       .verdict = verdict_of(row.at("verdict"), run),
                                       .terms = {},
                                       .mean = {},
                                       .covariance = {},
                                       .covariance_of = "white noise",
                                       .scale = {},
                                       .base_measured = has_base(run)};
    ident::Model model = model_of(row);
    const auto size = std::ssize(model.terms);
    model.covariance = matrix_of(row.value("covariance_robust", Json()), size);
    if (model.covariance.size() > 0) {
      equation.covariance_of = "residuals of any colour";
    } else {
      model.covariance = matrix_of(row.value("covariance", Json()), size);
      if (!row.value("sensors", Json::array()).empty()) equation.covariance_of = "noise and sensors";
    }
    if (model.covariance.size() == 0) {
      model.covariance = Eigen::MatrixXd::Zero(size, size);
      for (Eigen::Index i = 0; i < size; ++i)
        if (const double std = model.terms[static_cast<std::size_t>(i)].std; std::isfinite(std))
          model.covariance(i, i) = std * std;
    }
    if (differs_by_recording(model)) {
      model = equation_of(model, 0);
      equation.covariance_of += ", and the scatter between recordings where coefficients differ (their mean is taken)";
    }
    equation.covariance = model.covariance;
    equation.mean.resize(std::ssize(model.terms));
    equation.scale.resize(equation.mean.size());
    for (const ident::ModelTerm& term : model.terms) {
      const auto i = std::ssize(equation.terms);
      equation.mean[i] = term.mean;
      equation.scale[i] = term.scale;
      equation.terms.push_back(term.name);
    }
    return equation;
  } catch (const Json::exception& error) {
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged",
                     fmt::format("{}: {}", (run / "equation.json").string(), error.what()));
  }
}

PredictedEquation read_predicting_equation(const fs::path& run, const std::string& range, const std::string& method) {
  const Json document = read_run_json(run / "equation.json");
  try {
    const std::optional<Row> found = chosen(document, range, method);
    if (!found) refuse_choice(document, run, range, method);
    PredictedEquation equation{found->range, model_of(*found->equation), {}};
    for (const Json& one : document.at("ranges"))
      if (one.at("name") == found->range && one.contains("linear")) equation.linear = model_of(one.at("linear"));
    return equation;
  } catch (const Json::exception& error) {
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged",
                     fmt::format("{}: {}", (run / "equation.json").string(), error.what()));
  }
}

}  // namespace apps
