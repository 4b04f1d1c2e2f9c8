#pragma once
#include <string>
#include <utility>
#include <vector>

namespace apps {

/// "p=v" as name and number. Throws std::invalid_argument.
[[nodiscard]] std::vector<std::pair<std::string, double>> parse_settings(const std::vector<std::string>& settings);

}  // namespace apps
