#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// replicate.json as it grows: what is compared with the print, tabulated and shown is what stands in it.

namespace apps {

using Json = nlohmann::ordered_json;
using JsonRows = std::vector<const Json*>;

/// NaN for null.
[[nodiscard]] double number_in(const Json& value);

/// The rows that have all these values.
[[nodiscard]] JsonRows matching(const Json& rows, const Json& values);
/// Groups of rows that share the values of these keys, in the order of their first rows; [values, rows].
[[nodiscard]] std::vector<std::pair<Json, JsonRows>> grouped(const JsonRows& rows,
                                                             const std::vector<std::string>& keys);
/// Mean of a number of each row, "/nmse/train"; NaN where one of them or all are missing.
[[nodiscard]] double mean_of(const JsonRows& rows, const std::string& path);

/// A term as fits have found it: means over those that keep it; NaN where none does.
struct FoundTerm {
  double mean = 0.0, std = 0.0, mean_scaled = 0.0, std_scaled = 0.0, cov = 0.0, t = 0.0;
  std::string unit = {};
  int kept = 0;
};
[[nodiscard]] FoundTerm found_term(const JsonRows& fits, const std::string& name);

}  // namespace apps
