#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/output/run_changes.hpp"
#include "apps/text/text_grid.hpp"

namespace apps {

/// What one run says in one range.
struct ComparedColumn {
  std::string title;
  nlohmann::ordered_json fit;  ///< of metrics.json; null: the run has no such range
  std::string verdict;         ///< with its cause; empty: not known
};

/// A term of the equations; `label` tells that of one recording from that of another.
struct ComparedTerm {
  std::string name, label;  ///< "sgn(v)", "sgn(v) in run1.csv"
};

/// One range of several runs, or of several bodies one of their equations, or their modes.
struct RangeComparison {
  std::string range;
  std::string heading = {};  ///< "range mixed", "equation for a1"
  bool of_coefficients = true;
  std::vector<std::string> figures = {"train", "test", "free_run"};  ///< of its NMSE
  std::vector<ComparedTerm> terms;                                   ///< of all runs, in order of appearance
  std::vector<ComparedColumn> columns;
  std::map<std::string, double> truth;  ///< by label, in the units of what was recorded; empty: not known
};

/// What differs between several finished runs (inputs by their bytes, settings, program), then their verdicts,
/// equations and NMSE range by range; of several bodies equation by equation, and their modes.
struct RunComparison {
  std::vector<std::string> titles;
  std::vector<Change> changes;
  std::vector<RangeComparison> ranges;
  nlohmann::ordered_json truth;  ///< truth.json; null: none was given
};

/// `truth_file`: truth.json of a simulation, or empty. The first method of a run that does not have `method`. Throws
/// dsp::Fault (input, "run.incomplete", "run.damaged") for a run without fits.
[[nodiscard]] RunComparison compare_runs(const std::vector<std::filesystem::path>& run_folders,
                                         const std::filesystem::path& truth_file, const std::string& method);

/// Terms in rows, runs in columns. Coefficients come with their difference from the first run in standard deviations of
/// that difference or, where the truth is known, with whether it is inside their 95 % interval.
[[nodiscard]] TextGrid grid_of(const RangeComparison& comparison);
/// What differs in rows, runs in columns.
[[nodiscard]] TextGrid changes_grid(const RunComparison& comparison);
/// The term with a label in a run's equation, as metrics.json has it; nullptr: not in it.
[[nodiscard]] const nlohmann::ordered_json* term_of(const ComparedColumn& column, const std::string& label);
void term_of(const ComparedColumn&&, const std::string&) = delete;

/// As text of at most 120 columns; more than four runs are rows.
[[nodiscard]] std::string to_text(const RunComparison& comparison);
[[nodiscard]] std::string to_json(const RunComparison& comparison);

}  // namespace apps
