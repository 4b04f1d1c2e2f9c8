#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ident/identify.hpp"

// metrics.json: figures of merit of every range and method, with the keys that scripts rely on.

namespace apps {

[[nodiscard]] std::string metrics_json(const std::vector<ident::RangeResult>& ranges,
                                       const ident::IdentifyOptions& options);

/// Of this document or equation.json: what a range says of a method, or of its first where it does not have that; null:
/// it says nothing.
[[nodiscard]] nlohmann::ordered_json fit_of(const nlohmann::ordered_json& document, const std::string& range,
                                            const std::string& method);

}  // namespace apps
