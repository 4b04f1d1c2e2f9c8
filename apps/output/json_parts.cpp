#include "apps/output/json_parts.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/process/printable.hpp"

namespace apps {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& document) {
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void put(Json& object, const std::string& key, double value, std::string_view reason) {
  if (std::isfinite(value)) {
    object[key] = value;
    return;
  }
  object[key] = nullptr;
  object[key + "_reason"] = reason;
}

Json calibration_json(const std::vector<std::string>& uncalibrated) {
  Json result{{"calibrated", uncalibrated.empty()}};
  if (uncalibrated.empty()) return result;
  result["uncalibrated"] = Json::array();
  for (const std::string& channel : uncalibrated) result["uncalibrated"].push_back(printable(channel));
  return result;
}

}  // namespace apps
