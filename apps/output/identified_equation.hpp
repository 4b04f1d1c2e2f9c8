#pragma once
#include <filesystem>
#include <string>

#include "ident/equation/identified_equation.hpp"

namespace apps {

/// Reads the equation of a range and method from a run folder's equation.json. Left out, each is as
/// the run chose it, or the first. Throws dsp::Fault: "run.incomplete",
/// "run.damaged" (input), "run.no_such_equation" (usage) with what there is.
[[nodiscard]] ident::IdentifiedEquation read_equation(const std::filesystem::path& run, const std::string& range,
                                                      const std::string& method);

}  // namespace apps
