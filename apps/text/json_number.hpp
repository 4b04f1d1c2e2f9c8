#pragma once
#include <cmath>
#include <nlohmann/json.hpp>

namespace apps {

/// JSON has no NaN and no infinity: null stands for a number that does not exist.
[[nodiscard]] inline nlohmann::ordered_json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

}  // namespace apps
