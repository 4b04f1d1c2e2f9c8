#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

// Pieces that the documents of a run share.

namespace apps {

/// A document as it is written: two blanks a level, text made valid UTF-8, a line end at the end.
[[nodiscard]] std::string text_of(const nlohmann::ordered_json& document);

/// Sets a number, or null with the reason beside it where there is none (KEY_reason).
void put(nlohmann::ordered_json& object, const std::string& key, double value, std::string_view reason);

/// {"calibrated": ...} and, where it is false, the channels that are not.
[[nodiscard]] nlohmann::ordered_json calibration_json(const std::vector<std::string>& uncalibrated);

}  // namespace apps
