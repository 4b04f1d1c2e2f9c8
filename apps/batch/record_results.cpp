#include "apps/batch/record_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/batch/batch_folder.hpp"
#include "apps/output/equation_file.hpp"
#include "apps/output/factors_file.hpp"
#include "apps/output/metrics_file.hpp"
#include "apps/output/run_json.hpp"
#include "apps/process/printable.hpp"
#include "dsp/values/fault.hpp"
#include "ident/judgement/judge.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;

/// The member as table.json may have it: a number, text to show, or null.
Json at(const Json& object, const char* key) {
  const Json value = object.is_object() ? object.value(key, Json()) : Json();
  if (value.is_string()) return printable(value.get<std::string>());
  return value.is_number() ? value : Json();
}

/// A range of equation.json by its speaking method, with its figures in metrics.json.
Json range_row(const Json& equation, const Json& range, const Json& metrics) {
  const std::string name = range.at("name");
  const Json &chosen = equation.at("chosen"), &ranges = metrics.at("ranges");
  const auto figures =
      std::find_if(ranges.begin(), ranges.end(), [&](const Json& one) { return one.at("name") == name; });
  const Json fit = fit_of(equation, name, speaking_method(equation, range));
  const Json of_fit = fit.is_null() ? Json() : fit_of(metrics, name, fit.at("method"));
  const Json nmse = of_fit.is_null() ? Json() : of_fit.at("nmse");
  Json row{{"name", printable(name)},
           {"chosen", chosen.is_object() && chosen.at("range") == name},
           {"verdict", at(fit, "verdict")},
           {"cause", at(fit, "cause")},
           {"method", at(fit, "method")},
           {"equation", at(fit, "text")},
           {"num_train", figures == ranges.end() ? Json() : at(*figures, "num_train")},
           {"num_effective", at(of_fit, "num_effective")},
           {"nmse",
            {{"train", at(nmse, "train_centred")},
             {"test", at(nmse, "test_centred")},
             {"free_run", at(nmse, "free_run_centred")}}},
           {"terms", Json::array()}};
  if (fit.is_null()) return row;
  for (const Json& term : fit.at("terms"))
    row["terms"].push_back(
        {{"name", label_of(term)}, {"mean", at(term, "mean")}, {"std", at(term, "std")}, {"unit", at(term, "unit")}});
  return row;
}

/// Without the folders of this machine: outputs are not to hold them.
std::string without_folder(std::string text, const fs::path& folder) {
  const std::string prefix = folder.string() + "/";
  for (std::size_t at = 0; !folder.empty() && (at = text.find(prefix, at)) != std::string::npos;)
    text.erase(at, prefix.size());
  return text;
}

/// Where the lines to paste are that a sentence ends with, which has no room for them.
std::string with_place_of_lines(std::string error, const std::string& recording) {
  if (error.ends_with(':')) error += fmt::format(" `ardent check {}` prints the lines", recording);
  return error;
}

void read_run(const fs::path& folder, RecordResult& result) {
  const Json equation = read_run_json(folder / "equation.json"), metrics = read_run_json(folder / "metrics.json");
  for (const Json& range : equation.at("ranges")) result.ranges.push_back(range_row(equation, range, metrics));
  std::error_code unknown;
  if (fs::exists(folder / factors_name, unknown)) result.factors = read_factors(folder);
}

void require_verdicts(RecordResult& result, const std::string& require) {
  const std::optional<ident::Verdict> least = ident::verdict_from_string(require);
  for (const Json& range : result.ranges) {
    if (!least || range.at("method").is_null()) continue;
    const std::string text = range.at("verdict").is_null() ? "" : range.at("verdict");
    const std::optional<ident::Verdict> verdict = ident::verdict_from_string(text);
    if (verdict && ident::preference(*verdict) >= ident::preference(*least)) continue;
    if (result.error.empty())
      result.error = fmt::format("[verdict.required] range '{}': the verdict is {}, --require {} wants better",
                                 range.at("name").get<std::string>(), text, require);
    result.exit_code = std::max(result.exit_code, 4);
  }
}

}  // namespace

RecordResult record_result(const RecordTask& task, const TaskOutcome& outcome, const fs::path& runs,
                           const std::string& require) {
  RecordResult result{
      .recording = printable(task.called),
      .exit_code = outcome.exit_code,
      .was_kept = outcome.was_kept,
      .error = with_place_of_lines(without_folder(without_folder(outcome.error, runs), task.recording.parent_path()),
                                   task.recording.filename().string())};
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

}  // namespace apps
