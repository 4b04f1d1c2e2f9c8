#include "apps/output/run_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/output/run_json.hpp"
#include "apps/process/path.hpp"
#include "apps/process/printable.hpp"
#include "dsp/fault.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;

/// One column of the comparison: what one run says in one range.
struct Column {
  std::string title;
  Json fit;  ///< null: the run has no such range
};

struct Comparison {
  std::string range;
  std::vector<std::string> terms;  ///< of all columns, in order of appearance
  std::vector<Column> columns;
};

Json fit_of(const Json& metrics, const std::string& range, const std::string& method) {
  for (const Json& candidate : metrics.at("ranges")) {
    if (candidate.at("name") != range) continue;
    const Json& methods = candidate.at("methods");
    for (const Json& fit : methods)
      if (fit.at("method") == method) return fit;
    return methods.empty() ? Json() : methods.front();
  }
  return {};
}

std::vector<Comparison> comparisons(const std::vector<std::pair<std::string, Json>>& runs, const std::string& method) {
  std::vector<Comparison> all;
  for (const auto& run : runs)
    for (const Json& range : run.second.at("ranges")) {
      const std::string name = range.at("name");
      if (std::none_of(all.begin(), all.end(), [&](const Comparison& one) { return one.range == name; }))
        all.push_back({name, {}, {}});
    }
  for (Comparison& one : all)
    for (const auto& [title, metrics] : runs) {
      one.columns.push_back({title, fit_of(metrics, one.range, method)});
      if (one.columns.back().fit.is_null()) continue;
      for (const Json& term : one.columns.back().fit.at("terms")) {
        const std::string name = term.at("name");
        if (std::find(one.terms.begin(), one.terms.end(), name) == one.terms.end()) one.terms.push_back(name);
      }
    }
  return all;
}

std::string number_or_none(const Json& value, const char* format) {
  return value.is_number() ? fmt::format(fmt::runtime(format), value.get<double>()) : "none";
}

/// What a simulation says of each term.
class Truth {
 public:
  /// In the units of the sensors that recorded it, where the file says so and the runs are of the recording.
  Truth(const Json& document, bool of_recording)
      : terms_(document.at(of_recording && document.contains("terms_as_recorded") ? "terms_as_recorded" : "terms")) {}
  /// 0 of a term that the simulation does not have, or has for another target.
  [[nodiscard]] double value(const Json& target, const std::string& term) const {
    for (const Json& candidate : terms_)
      if (candidate.at("name") == term && candidate.value("target", Json("a")) == target)
        return candidate.at("value").get<double>();
    return 0.0;
  }

 private:
  Json terms_;
};

/// A simulation writes the exact motion beside what its sensors recorded of it.
bool is_of_exact_motion(const fs::path& run) {
  const Json manifest = read_run_json(run / "manifest.json");
  const Json& inputs = manifest.at("inputs");
  return std::any_of(inputs.begin(), inputs.end(), [](const Json& input) {
    return fs::path(input.at("path").get<std::string>()).filename() == "response.csv";
  });
}

constexpr double coverage_95 = 1.96;  // standard deviations to either side of a normal distribution

/// With the coefficient of variation; beside a true value with the standard deviation, and whether that value is inside
/// the 95 % interval.
std::string coefficient(const Json& fit, const std::string& term, const double* truth) {
  if (fit.is_null()) return "";
  for (const Json& candidate : fit.at("terms")) {
    if (candidate.at("name") != term) continue;
    const std::string mean = number_or_none(candidate.at("mean"), "{:.6g}");
    if (truth == nullptr) return mean + " (" + number_or_none(candidate.at("cov"), "{:.1e}") + ")";
    const Json& std = candidate.at("std");
    if (!std.is_number()) return fmt::format("{} +- none {:>7}", mean, "");
    const bool inside = std::abs(candidate.at("mean").get<double>() - *truth) <= coverage_95 * std.get<double>();
    return fmt::format("{} +- {:.2g} {:>7}", mean, std.get<double>(), inside ? "inside" : "outside");
  }
  return "-";
}

std::string text_of(const Comparison& one, const std::optional<Truth>& truth) {
  std::string text = fmt::format("range {}\n  {:<16}", printable(one.range), "term");
  if (truth) text += fmt::format(" {:>12}", "truth");
  const int width = truth ? 32 : 24;
  for (const Column& column : one.columns)
    text += fmt::format(" {:>{}}", printable(column.title) + (truth ? "" : " (CoV)"), width);
  text += "\n";
  const auto with_fit =
      std::find_if(one.columns.begin(), one.columns.end(), [](const Column& column) { return !column.fit.is_null(); });
  const Json target = with_fit == one.columns.end() ? Json() : with_fit->fit.at("target");
  for (const std::string& term : one.terms) {
    text += fmt::format("  {:<16}", printable(term));
    const double true_one = truth ? truth->value(target, term) : 0.0;
    if (truth) text += fmt::format(" {:>12.6g}", true_one);
    for (const Column& column : one.columns)
      text += fmt::format(" {:>{}}", coefficient(column.fit, term, truth ? &true_one : nullptr), width);
    text += "\n";
  }
  for (const char* figure : {"train", "test", "free_run"}) {
    text += fmt::format("  {:<16}", fmt::format("NMSE {}", figure));
    if (truth) text += fmt::format(" {:>12}", "");
    for (const Column& column : one.columns)
      text += fmt::format(
          " {:>{}}", column.fit.is_null() ? "" : number_or_none(column.fit.at("nmse").at(figure), "{:.3g}"), width);
    text += "\n";
  }
  return text + "\n";
}

std::string json_of(const std::vector<Comparison>& all, const Json& truth) {
  Json document{{"ranges", Json::array()}};
  for (const Comparison& one : all) {
    Json row{{"name", one.range}, {"runs", Json::array()}};
    for (const Column& column : one.columns)
      row["runs"].push_back({{"run", printable(column.title)}, {"fit", column.fit}});
    document["ranges"].push_back(std::move(row));
  }
  if (!truth.is_null()) document["truth"] = truth.at("terms");
  if (truth.contains("terms_as_recorded")) document["truth_as_recorded"] = truth.at("terms_as_recorded");
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string comparison_of(const std::vector<fs::path>& run_folders, const fs::path& truth_file,
                          const std::string& method, bool as_json) {
  std::vector<std::pair<std::string, Json>> runs;
  for (const fs::path& run : run_folders)
    runs.emplace_back(named_path(run).filename().string(), read_run_json(run / "metrics.json"));
  const Json truth = truth_file.empty() ? Json() : read_run_json(truth_file);
  try {
    const std::vector<Comparison> all = comparisons(runs, method);
    if (as_json) return json_of(all, truth);
    std::optional<Truth> known;
    if (!truth.is_null())
      known.emplace(truth, std::none_of(run_folders.begin(), run_folders.end(), is_of_exact_motion));
    std::string text;
    for (const Comparison& one : all) text += text_of(one, known);
    return text;
  } catch (const Json::exception& error) {
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged", fmt::format("metrics.json or truth.json: {}", error.what()));
  }
}

}  // namespace apps
