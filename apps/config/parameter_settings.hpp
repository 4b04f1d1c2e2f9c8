#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "sim/systems.hpp"

namespace apps {

/// "p=v" as name and number. Throws std::invalid_argument.
[[nodiscard]] std::vector<std::pair<std::string, double>> parse_settings(const std::vector<std::string>& settings);

/// Rows of truth.json's "terms".
void append_terms(nlohmann::ordered_json& array, const std::vector<sim::TrueTerm>& terms);

}  // namespace apps
