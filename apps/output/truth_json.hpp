#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "sim/rig/rig_truth.hpp"

namespace apps {

/// truth.json's "parameters" and "terms", into `truth`.
void put_equation(nlohmann::ordered_json& truth, const std::vector<std::pair<std::string, double>>& parameters,
                  const std::vector<sim::TrueTerm>& terms);

/// A rig test's part of truth.json, into `truth`; `recorded`: with what its sensors were.
void put_rig_truth(nlohmann::ordered_json& truth, const sim::RigTest& test, const sim::RigTruth& known, bool recorded);

}  // namespace apps
