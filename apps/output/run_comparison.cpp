#include "apps/output/run_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "apps/output/equation_file.hpp"
#include "apps/output/manifest.hpp"
#include "apps/output/metrics_file.hpp"
#include "apps/output/run_json.hpp"
#include "apps/output/truth_json.hpp"
#include "apps/process/path.hpp"
#include "apps/process/printable.hpp"
#include "apps/text/json_parts.hpp"
#include "dsp/values/fault.hpp"
#include "ident/equation/interval_95.hpp"

namespace apps {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* modes_range = "modes";

/// A run as its folder has it.
struct ComparedRun {
  std::string title;
  Json metrics, equation;  ///< equation null: there is none
  [[nodiscard]] bool of_bodies() const { return equation.is_object() && equation.contains("bodies"); }
};

/// The equations of several bodies and their modes, as if each were a range with one fit.
Json metrics_of_bodies(const Json& equation) {
  Json ranges = Json::array();
  const auto add = [&](const std::string& name, Json target, Json terms, Json free_run) {
    const Json nmse{{"train", nullptr}, {"test", nullptr}, {"free_run", std::move(free_run)}};
    const Json fit{
        {"method", "likelihood"}, {"target", std::move(target)}, {"terms", std::move(terms)}, {"nmse", nmse}};
    ranges.push_back({{"name", name}, {"methods", Json::array({fit})}});
  };
  for (const Json& body : equation.at("bodies"))
    add(body.at("target"), body.at("target"), body.at("terms"), body.value("free_run_nmse", Json()));
  if (equation.contains("inner") && equation["inner"].at("kept").get<bool>())
    add(equation["inner"].at("target"), equation["inner"].at("target"), equation["inner"].at("terms"), {});
  Json modes = Json::array();
  for (const Json& mode : equation.at("modes")) {
    const std::size_t number = modes.size() / 2 + 1;
    modes.push_back({{"name", fmt::format("natural frequency {}", number)},
                     {"mean", mode.at("frequency_hz")},
                     {"std", mode.at("frequency_std")},
                     {"unit", "Hz"}});
    modes.push_back({{"name", fmt::format("damping ratio {}", number)},
                     {"mean", mode.at("damping_ratio")},
                     {"std", mode.at("damping_ratio_std")},
                     {"unit", ""}});
  }
  if (!modes.empty()) add(modes_range, nullptr, std::move(modes), {});
  return {{"ranges", std::move(ranges)}};
}

/// "in_part (missing_input)", as equation.json has it for the method of `fit`.
std::string verdict_of(const Json& equation, const std::string& range, const Json& fit) {
  const Json one = equation.is_null() || fit.is_null() ? Json() : fit_of(equation, range, fit.at("method"));
  if (one.is_null() || one.at("method") != fit.at("method")) return "";
  const Json verdict = one.value("verdict", Json()), cause = one.value("cause", Json());
  if (!verdict.is_string()) return "";
  return verdict.get<std::string>() + (cause.is_string() ? fmt::format(" ({})", cause.get<std::string>()) : "");
}

std::vector<RangeComparison> range_comparisons(const std::vector<ComparedRun>& runs, const std::string& method) {
  std::vector<RangeComparison> all;
  for (const ComparedRun& run : runs)
    for (const Json& range : run.metrics.at("ranges")) {
      const std::string name = range.at("name");
      if (std::any_of(all.begin(), all.end(), [&](const RangeComparison& one) { return one.range == name; })) continue;
      RangeComparison& one = all.emplace_back();
      one.range = name;
      one.heading = "range " + name;
      if (!run.of_bodies()) continue;
      one.of_coefficients = name != modes_range;
      one.heading = one.of_coefficients ? "equation for " + name : name;
      one.figures.clear();
      if (range.at("methods").front().at("nmse").at("free_run").is_number()) one.figures = {"free_run"};
    }
  for (RangeComparison& one : all)
    for (const ComparedRun& run : runs) {
      Json fit = fit_of(run.metrics, one.range, method);
      std::string verdict =
          run.of_bodies() ? run.equation.value("verdict", "") : verdict_of(run.equation, one.range, fit);
      one.columns.push_back({run.title, std::move(fit), std::move(verdict)});
      if (one.columns.back().fit.is_null()) continue;
      for (const Json& term : one.columns.back().fit.at("terms")) {
        const std::string label = label_of(term);
        if (std::none_of(one.terms.begin(), one.terms.end(),
                         [&](const ComparedTerm& known) { return known.label == label; }))
          one.terms.push_back({term.at("name"), label});
      }
    }
  return all;
}

std::string number_or_none(const Json& value, const char* format) {
  return value.is_number() ? fmt::format(fmt::runtime(format), value.get<double>()) : "none";
}

/// A simulation writes the exact motion beside what its sensors recorded of it.
bool is_of_exact_motion(const fs::path& run) {
  const std::vector<ManifestFile> inputs = read_manifest(run).value_or(Manifest()).inputs;
  return std::any_of(inputs.begin(), inputs.end(),
                     [](const ManifestFile& input) { return fs::path(input.path).filename() == "response.csv"; });
}

const Json* term_of(const Json& fit, const std::string& label) {
  if (fit.is_null()) return nullptr;
  for (const Json& candidate : fit.at("terms"))
    if (label_of(candidate) == label) return &candidate;
  return nullptr;
}

std::string with_std(const Json& term) {
  const Json& std = term.at("std");
  return number_or_none(term.at("mean"), "{:.6g}") +
         (std.is_number() ? fmt::format(" +- {:.2g}", std.get<double>()) : " +- none");
}

/// Beside a true value: whether it is inside the 95 % interval.
std::string beside_truth(const Json& term, double truth) {
  const Json& std = term.at("std");
  if (!std.is_number()) return with_std(term);
  const bool inside = std::abs(term.at("mean").get<double>() - truth) <= ident::interval_95 * std.get<double>();
  return fmt::format("{} {:>7}", with_std(term), inside ? "inside" : "outside");
}

/// Beside the first run: by how many standard deviations of the difference it is larger.
std::string beside_first(const Json& term, const Json* first) {
  const std::string text = with_std(term);
  if (first == nullptr || !term.at("std").is_number() || !first->at("std").is_number()) return text;
  const double difference = term.at("mean").get<double>() - first->at("mean").get<double>();
  const double deviation = std::hypot(term.at("std").get<double>(), first->at("std").get<double>());
  return difference == 0.0 ? text + " (=)"
                           : fmt::format("{} ({:+.1f})", text, std::round(10.0 * difference / deviation) / 10.0 + 0.0);
}

std::vector<std::string> term_cells(const RangeComparison& one, const std::string& label,
                                    const std::optional<double>& truth) {
  std::vector<std::string> cells;
  for (const ComparedColumn& column : one.columns) {
    const Json* own = term_of(column.fit, label);
    if (own == nullptr)
      cells.emplace_back(column.fit.is_null() ? "" : "-");
    else if (truth)
      cells.push_back(beside_truth(*own, *truth));
    else
      cells.push_back(&column == &one.columns.front() ? with_std(*own)
                                                      : beside_first(*own, term_of(one.columns.front().fit, label)));
  }
  return cells;
}

void add_row(TextGrid& grid, const std::string& name, std::vector<std::string> cells) {
  grid.rows.push_back(printable(name));
  grid.cells.push_back(std::move(cells));
}

/// The target of the first run that has such a range.
Json target_of(const RangeComparison& one) {
  for (const ComparedColumn& column : one.columns)
    if (!column.fit.is_null()) return column.fit.at("target");
  return {};
}

std::optional<double> truth_of(const RangeComparison& one, const std::string& label) {
  const auto found = one.truth.find(label);
  return found == one.truth.end() ? std::nullopt : std::optional<double>(found->second);
}

Json changes_json(const std::vector<Change>& changes) {
  constexpr std::array kinds{"program", "input", "setting"};
  Json list = Json::array();
  for (const Change& change : changes) {
    Json one{{"kind", kinds[static_cast<std::size_t>(change.kind)]},
             {"what", printable(change.what)},
             {"values", Json::array()}};
    for (const std::string& value : change.values)
      one["values"].push_back(value.empty() ? Json() : Json(printable(value)));
    list.push_back(std::move(one));
  }
  return list;
}

}  // namespace

TextGrid grid_of(const RangeComparison& one) {
  TextGrid grid{"term", {}, {}, {}};
  for (const ComparedColumn& column : one.columns) grid.columns.push_back(printable(column.title));
  std::vector<std::string> verdicts, true_cells{""};
  for (const ComparedColumn& column : one.columns) verdicts.push_back(column.verdict);
  add_row(grid, "verdict", verdicts);
  for (const auto& [name, label] : one.terms) {
    const std::optional<double> value = truth_of(one, label);
    if (value) true_cells.push_back(fmt::format("{:.6g}", *value));
    add_row(grid, label, term_cells(one, label, value));
  }
  for (const std::string& figure : one.figures) {
    std::vector<std::string> cells;
    for (const ComparedColumn& column : one.columns)
      cells.push_back(column.fit.is_null() ? "" : number_or_none(column.fit.at("nmse").at(figure), "{:.3g}"));
    add_row(grid, fmt::format("NMSE {}", figure), std::move(cells));
  }
  if (one.truth.empty()) return grid;
  grid.columns.insert(grid.columns.begin(), "truth");
  true_cells.resize(grid.rows.size());
  for (std::size_t row = 0; row < grid.rows.size(); ++row)
    grid.cells[row].insert(grid.cells[row].begin(), true_cells[row]);
  return grid;
}

TextGrid changes_grid(const RunComparison& comparison) {
  TextGrid grid{"what differs", comparison.titles, {}, {}};
  for (const Change& change : comparison.changes) {
    const char* kind = change.kind == Change::Kind::input ? "input " : "";
    std::vector<std::string> cells;
    for (const std::string& value : change.values) cells.push_back(value.empty() ? "-" : printable(value));
    add_row(grid, kind + change.what, std::move(cells));
  }
  return grid;
}

RunComparison compare_runs(const std::vector<fs::path>& run_folders, const fs::path& truth_file,
                           const std::string& method) {
  RunComparison result{distinct_names(run_folders), {}, {}, truth_file.empty() ? Json() : read_run_json(truth_file)};
  std::vector<ComparedRun> runs;
  for (std::size_t i = 0; i < run_folders.size(); ++i) {
    const fs::path equation = run_folders[i] / "equation.json";
    std::error_code unknown;
    runs.push_back({result.titles[i], read_run_json(run_folders[i] / "metrics.json"),
                    fs::exists(equation, unknown) ? read_run_json(equation) : Json()});
  }
  try {
    for (ComparedRun& run : runs)
      if (run.of_bodies()) run.metrics = metrics_of_bodies(run.equation);
    result.ranges = range_comparisons(runs, method);
    result.changes = changes_between(run_folders);
    if (!result.truth.is_null()) {
      const bool of_recording = std::none_of(run_folders.begin(), run_folders.end(), is_of_exact_motion);
      for (RangeComparison& one : result.ranges) {
        if (!one.of_coefficients) continue;
        for (const auto& [name, label] : one.terms)
          one.truth[label] = true_value(result.truth, of_recording, target_of(one), name);
      }
    }
    for (const RangeComparison& one : result.ranges) (void)grid_of(one);  // whatever an edited file lacks shows here
    return result;
  } catch (const Json::exception& error) {
    throw dsp::Fault(dsp::FaultKind::input, "run.damaged",
                     fmt::format("metrics.json, equation.json or truth.json: {}", error.what()));
  }
}

std::string to_text(const RunComparison& comparison) {
  constexpr std::size_t most_beside = 4;
  const bool several = comparison.titles.size() > 1, upright = comparison.titles.size() <= most_beside;
  std::string text;
  if (several && comparison.changes.empty()) text = "the same inputs, settings and program\n\n";
  if (several && !comparison.changes.empty()) {
    const TextGrid grid = changes_grid(comparison);
    text = to_text(upright ? grid : transposed(grid)) + "\n";
  }
  bool differences = false;
  for (const RangeComparison& one : comparison.ranges) {
    TextGrid grid = grid_of(one);
    for (const auto& cells : grid.cells)
      differences = differences || std::any_of(cells.begin(), cells.end(), [](const std::string& cell) {
                      return cell.find(" (") != std::string::npos && cell.find("+-") != std::string::npos;
                    });
    if (!upright) grid.corner = "run";
    text += fmt::format("{}\n{}\n", printable(one.heading), to_text(upright ? grid : transposed(grid)));
  }
  if (several && differences)
    text += fmt::format("in brackets: the difference from {} in standard deviations of that difference\n",
                        comparison.titles.front());
  return text;
}

std::string to_json(const RunComparison& comparison) {
  Json document{{"changes", changes_json(comparison.changes)}, {"ranges", Json::array()}};
  for (const RangeComparison& one : comparison.ranges) {
    Json row{{"name", one.range}, {"runs", Json::array()}};
    for (const ComparedColumn& column : one.columns)
      row["runs"].push_back({{"run", printable(column.title)}, {"verdict", column.verdict}, {"fit", column.fit}});
    document["ranges"].push_back(std::move(row));
  }
  const Json& truth = comparison.truth;
  if (!truth.is_null()) document["truth"] = truth.at("terms");
  if (truth.contains("terms_as_recorded")) document["truth_as_recorded"] = truth.at("terms_as_recorded");
  return text_of(document);
}

const Json* term_of(const ComparedColumn& column, const std::string& label) {
  return term_of(column.fit, label);
}

}  // namespace apps
