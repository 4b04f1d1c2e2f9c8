#pragma once
#include <fmt/format.h>

#include <string>

namespace ident {

/// A fraction as people say it, to two digits: "0.28 %", "97 %", "100 %".
[[nodiscard]] inline std::string percent(double fraction) {
  return fraction > 0.99 ? fmt::format("{:.0f} %", 100.0 * fraction) : fmt::format("{:.2g} %", 100.0 * fraction);
}

}  // namespace ident
