#include "apps/text/json_parts.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/process/printable.hpp"
#include "ident/identify.hpp"

namespace apps {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& document) {
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json parsed_json(std::string_view text) {
  constexpr std::size_t deepest = 64, most_keys = 1000;
  std::array<std::size_t, deepest + 1> keys{};  // so far, of the object at each depth
  return Json::parse(text, [&](int at, Json::parse_event_t event, const Json&) {
    const auto depth = static_cast<std::size_t>(at);
    if (depth > deepest) throw std::invalid_argument(fmt::format("nested more than {} levels deep", deepest));
    if (event == Json::parse_event_t::object_start) keys[depth] = 0;
    if (event == Json::parse_event_t::key && ++keys[depth - 1] > most_keys)
      throw std::invalid_argument(fmt::format("an object of more than {} keys", most_keys));
    return true;
  });
}

void put(Json& object, const std::string& key, double value, std::string_view reason) {
  if (std::isfinite(value)) {
    object[key] = value;
    return;
  }
  object[key] = nullptr;
  object[key + "_reason"] = reason;
}

void put(Json& object, const std::string& key, const ident::Figure& figure) {
  put(object, key, figure.reason.empty() ? figure.value : std::nan(""), printable(figure.reason));
}

Json coordinates_json(const std::vector<ident::Coordinates>& coordinates) {
  Json list = Json::array();
  for (const ident::Coordinates& one : coordinates)
    list.push_back({{"recording", printable(one.recording)},
                    {"of", one.of},
                    {"unit", printable(one.unit)},
                    {"zero", one.zero},
                    {"zero_std", one.zero_std},
                    {"prepared_zero", one.prepared_zero},
                    {"lead_s", one.lead_s},
                    {"lead_std_s", one.lead_std_s}});
  return list;
}

std::vector<ident::Coordinates> coordinates_in(const Json& list) {
  std::vector<ident::Coordinates> coordinates;
  for (const Json& one : list)
    coordinates.push_back({.recording = one.at("recording"),
                           .of = one.value("of", "the displacement"),
                           .unit = one.value("unit", ""),
                           .zero = one.at("zero"),
                           .zero_std = one.at("zero_std"),
                           .prepared_zero = one.at("prepared_zero"),
                           .lead_s = one.at("lead_s"),
                           .lead_std_s = one.at("lead_std_s")});
  return coordinates;
}

Json calibration_json(const std::vector<std::string>& uncalibrated) {
  Json result{{"calibrated", uncalibrated.empty()}};
  if (uncalibrated.empty()) return result;
  result["uncalibrated"] = Json::array();
  for (const std::string& channel : uncalibrated) result["uncalibrated"].push_back(printable(channel));
  return result;
}

}  // namespace apps
