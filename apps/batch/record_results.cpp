#include "apps/batch/record_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/batch/batch_folder.hpp"
#include "apps/output/equation_file.hpp"
#include "apps/output/factors_file.hpp"
#include "apps/output/json_number.hpp"
#include "apps/output/json_parts.hpp"
#include "apps/output/run_json.hpp"
#include "apps/process/printable.hpp"
#include "dsp/fault.hpp"
#include "ident/validate/judge.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double number_at(const Json& object, const char* key) {
  const auto member = object.find(key);
  return member != object.end() && member->is_number() ? member->get<double>() : nan;
}

std::string text_at(const Json& object, const char* key) {
  const auto member = object.find(key);
  return member != object.end() && member->is_string() ? member->get<std::string>() : std::string();
}

const Json* with(const Json& list, const char* key, const std::string& value) {
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const Json& one) { return text_at(one, key) == value; });
  return found == list.end() ? nullptr : &*found;
}

RangeRow range_row(const Json& range, const Json& metrics, const std::string& method) {
  RangeRow row{.name = text_at(range, "name")};
  row.num_train = number_at(metrics, "num_train");
  row.num_effective = row.nmse_train = row.nmse_test = row.nmse_free_run = nan;
  const Json& methods = range.at("methods");
  if (methods.empty()) return row;
  const Json* fit = with(methods, "method", method);
  if (fit == nullptr) fit = &methods.front();
  row.verdict = text_at(*fit, "verdict");
  row.cause = text_at(*fit, "cause");
  row.method = text_at(*fit, "method");
  row.equation = text_at(*fit, "text");
  for (const Json& term : fit->at("terms"))
    row.terms.push_back({label_of(term), text_at(term, "unit"), number_at(term, "mean"), number_at(term, "std")});
  if (const Json* figures = with(metrics.at("methods"), "method", row.method)) {
    row.num_effective = number_at(*figures, "num_effective");
    const Json& nmse = figures->at("nmse");
    row.nmse_train = number_at(nmse, "train_centred");
    row.nmse_test = number_at(nmse, "test_centred");
    row.nmse_free_run = number_at(nmse, "free_run_centred");
  }
  return row;
}

/// Without the folders of this machine: outputs are not to hold them.
std::string without_folder(std::string text, const fs::path& folder) {
  const std::string prefix = folder.string() + "/";
  for (std::size_t at = 0; !folder.empty() && (at = text.find(prefix, at)) != std::string::npos;)
    text.erase(at, prefix.size());
  return text;
}

void read_run(const fs::path& folder, RecordResult& result) {
  const Json equation = read_run_json(folder / "equation.json"), metrics = read_run_json(folder / "metrics.json");
  const Json& chosen = equation.at("chosen");
  const std::string range = chosen.is_object() ? text_at(chosen, "range") : "";
  for (const Json& one : equation.at("ranges")) {
    const Json* figures = with(metrics.at("ranges"), "name", text_at(one, "name"));
    result.ranges.push_back(range_row(one, figures != nullptr ? *figures : one, speaking_method(equation, one)));
    result.ranges.back().chosen = result.ranges.back().name == range;
  }
  std::error_code unknown;
  if (fs::exists(folder / factors_name, unknown)) result.factors = read_factors(folder);
}

void require_verdicts(RecordResult& result, const std::string& require) {
  const std::optional<ident::Verdict> least = ident::verdict_from_string(require);
  for (const RangeRow& range : result.ranges) {
    if (!least || range.method.empty()) continue;
    const std::optional<ident::Verdict> verdict = ident::verdict_from_string(range.verdict);
    if (verdict && ident::preference(*verdict) >= ident::preference(*least)) continue;
    if (result.error.empty())
      result.error = fmt::format("[verdict.required] range '{}': the verdict is {}, --require {} wants better",
                                 range.name, range.verdict, require);
    result.exit_code = std::max(result.exit_code, 4);
  }
}

Json text_or_null(const std::string& text) {
  return text.empty() ? Json() : Json(printable(text));
}

Json range_json(const RangeRow& range) {
  Json json{{"name", printable(range.name)},
            {"chosen", range.chosen},
            {"verdict", text_or_null(range.verdict)},
            {"cause", text_or_null(range.cause)},
            {"method", text_or_null(range.method)},
            {"equation", text_or_null(range.equation)},
            {"num_train", number_or_null(range.num_train)},
            {"num_effective", number_or_null(range.num_effective)},
            {"nmse",
             {{"train", number_or_null(range.nmse_train)},
              {"test", number_or_null(range.nmse_test)},
              {"free_run", number_or_null(range.nmse_free_run)}}},
            {"terms", Json::array()}};
  for (const CoefficientResult& term : range.terms)
    json["terms"].push_back({{"name", term.name},
                             {"mean", number_or_null(term.mean)},
                             {"std", number_or_null(term.std)},
                             {"unit", term.unit}});
  return json;
}

}  // namespace

RecordResult record_result(const RecordTask& task, const TaskOutcome& outcome, const fs::path& runs,
                           const std::string& require) {
  RecordResult result{.recording = printable(task.called),
                      .exit_code = outcome.exit_code,
                      .was_kept = outcome.was_kept,
                      .error = without_folder(without_folder(outcome.error, runs), task.recording.parent_path())};
  if (!outcome.has_run) return result;
  result.run = fmt::format("{}/{}", BatchFolder::runs_name, task.name);
  try {
    read_run(runs / task.name, result);
    require_verdicts(result, require);
  } catch (const dsp::Fault& fault) {
    result.error = fmt::format("[{}] {}", fault.name(), fault.what());
  } catch (const Json::exception&) {
    result.error = fmt::format("[run.damaged] {}: a document of the run is not as it was written", result.run);
  }
  if (!result.error.empty() && result.exit_code == 0) result.exit_code = 3;
  return result;
}

std::vector<std::string> all_terms(const std::vector<RecordResult>& records) {
  std::vector<std::string> names;
  for (const RecordResult& record : records)
    for (const RangeRow& range : record.ranges)
      for (const CoefficientResult& term : range.terms)
        if (std::find(names.begin(), names.end(), term.name) == names.end()) names.push_back(term.name);
  return names;
}

std::string table_json(const std::vector<RecordResult>& records, const std::string& joint, const std::string& reason) {
  Json document{{"schema", 1}, {"num_records", records.size()}};
  document["num_failed"] =
      std::count_if(records.begin(), records.end(), [](const RecordResult& record) { return record.run.empty(); });
  document["records"] = Json::array();
  for (const RecordResult& record : records) {
    Json json{{"recording", record.recording},
              {"run", text_or_null(record.run)},
              {"exit_code", record.exit_code},
              {"error", text_or_null(record.error)},
              {"ranges", Json::array()}};
    for (const RangeRow& range : record.ranges) json["ranges"].push_back(range_json(range));
    document["records"].push_back(std::move(json));
  }
  document["joint"] = joint.empty() ? Json() : Json::parse(joint);
  if (joint.empty()) document["joint_reason"] = text_or_null(reason);
  return text_of(document);
}

}  // namespace apps
