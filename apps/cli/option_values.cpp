#include "apps/cli/option_values.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>

namespace apps {
namespace {

/// NaN where `text` is no number.
double number_from(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return !text.empty() && end == text.c_str() + text.size() ? value : std::nan("");
}

}  // namespace

ValueCheck whole_number(std::uint64_t from, std::uint64_t to) {
  return [=](std::string& text) {
    std::uint64_t value = 0;
    const char* const end = text.data() + text.size();
    const auto [read_to, error] = std::from_chars(text.data(), end, value);
    if (text.empty() || read_to != end || error != std::errc() || value < from || value > to)
      return fmt::format("want a whole number from {} to {}, got {}", from, to, text);
    text = std::to_string(value);
    return std::string();
  };
}

ValueCheck non_negative_number() {
  return [](std::string& text) {
    const double value = number_from(text);
    const bool fits = std::isfinite(value) && value >= 0.0;
    return fits ? std::string() : fmt::format("want a finite number not below 0, got {}", text);
  };
}

ValueCheck positive_number() {
  return [](std::string& text) {
    const double value = number_from(text);
    const bool fits = std::isfinite(value) && value > 0.0;
    return fits ? std::string() : fmt::format("want a finite number above 0, got {}", text);
  };
}

}  // namespace apps
