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

/// What a truth.json says of a term in an equation of this target: 0 where the simulation does not have it.
/// `of_recording`: in the units of the sensors that recorded it, where the file says so.
[[nodiscard]] double true_value(const nlohmann::ordered_json& truth, bool of_recording,
                                const nlohmann::ordered_json& target, const std::string& name);

}  // namespace apps
