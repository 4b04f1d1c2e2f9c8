#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

// Pieces that the documents of a run share.

namespace ident {
struct Coordinates;
struct Figure;
}  // namespace ident

namespace apps {

/// A document as it is written: two blanks a level, text made valid UTF-8, a line end at the end.
[[nodiscard]] std::string text_of(const nlohmann::ordered_json& document);

/// A document that may be anybody's. Throws Json::exception where it is none, std::invalid_argument with what is too
/// much where it is nested deeper than ours, which reach 8, or an object has more keys than ours, which have some 20:
/// each key is looked for among those before it.
[[nodiscard]] nlohmann::ordered_json parsed_json(std::string_view text);

/// Sets a number, or null with the reason beside it where there is none (KEY_reason).
void put(nlohmann::ordered_json& object, const std::string& key, double value, std::string_view reason);

void put(nlohmann::ordered_json& object, const std::string& key, const ident::Figure& figure);

/// Where x and f of an equation are in each recording: a list of objects with the members of ident::Coordinates.
[[nodiscard]] nlohmann::ordered_json coordinates_json(const std::vector<ident::Coordinates>& coordinates);
/// What coordinates_json wrote. Throws Json::exception where it did not.
[[nodiscard]] std::vector<ident::Coordinates> coordinates_in(const nlohmann::ordered_json& list);

/// {"calibrated": ...} and, where it is false, the channels that are not.
[[nodiscard]] nlohmann::ordered_json calibration_json(const std::vector<std::string>& uncalibrated);

}  // namespace apps
