#pragma once
#include <fmt/format.h>

#include <cmath>
#include <string>

namespace apps {

/// A number for a person or a cell; `missing` for one that does not exist.
[[nodiscard]] inline std::string number_text(double value, const char* format = "{:.3g}", const char* missing = "-") {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : missing;
}

[[nodiscard]] inline std::string three_digits(double value) {
  return number_text(value, "{:.3g}", "none");
}

}  // namespace apps
