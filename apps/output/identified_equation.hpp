#pragma once
#include <filesystem>
#include <string>

#include "ident/equation/identified_equation.hpp"
#include "ident/model.hpp"

namespace apps {

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
