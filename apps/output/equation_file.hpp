#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "ident/equation/identified_equation.hpp"
#include "ident/identify.hpp"

// equation.json: the equations of a run, with the keys that scripts rely on.

namespace apps {

/// `base_measured`: whether the base's motion is among the signals, which an equation without it takes to be at rest.
[[nodiscard]] std::string equation_json(const std::vector<ident::RangeResult>& ranges, bool base_measured);

/// A term as equation.json and metrics.json have it. `no_evidence`: the reason where a method computes none.
[[nodiscard]] nlohmann::ordered_json term_json(const ident::ModelTerm& term, const ident::Fit& fit,
                                               std::string_view no_evidence);
/// Of such a term: its name, "sgn(v) in run1.csv" where it is of one recording.
[[nodiscard]] std::string label_of(const nlohmann::ordered_json& term);

/// The method whose verdict a range of equation.json has; in folders of earlier versions, where no range says it, the
/// method that the run chose. Empty: there is none.
[[nodiscard]] std::string speaking_method(const nlohmann::ordered_json& equations, const nlohmann::ordered_json& range);

/// Reads the equation of a range and method from a run folder's equation.json. Left out, the range is the one that the
/// run chose, the method the one whose verdict the range has; else the first. Throws dsp::Fault: "run.incomplete",
/// "run.damaged" (input), "run.no_such_equation" (usage) with what there is.
[[nodiscard]] ident::IdentifiedEquation read_equation(const std::filesystem::path& run, const std::string& range,
                                                      const std::string& method);

/// The same equation as a model, with the linear one that it must beat; no terms: the run named none.
struct PredictedEquation {
  std::string range;
  ident::Model model, linear;
};
[[nodiscard]] PredictedEquation read_predicting_equation(const std::filesystem::path& run, const std::string& range,
                                                         const std::string& method);

}  // namespace apps
