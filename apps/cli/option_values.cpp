#include "apps/cli/option_values.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace apps {

CLI::Validator whole(std::uint64_t from, std::uint64_t to) {
  return {[=](std::string& text) {
            std::uint64_t value = 0;
            const char* const end = text.data() + text.size();
            const auto [read_to, error] = std::from_chars(text.data(), end, value);
            if (text.empty() || read_to != end || error != std::errc() || value < from || value > to)
              return fmt::format("want a whole number from {} to {}, got {}", from, to, text);
            text = std::to_string(value);
            return std::string();
          },
          ""};
}

CLI::Validator not_negative() {
  return {[](std::string& text) {
            double value = 0.0;
            const bool fits = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= 0.0;
            return fits ? std::string() : fmt::format("want a finite number not below 0, got {}", text);
          },
          "NOT NEGATIVE"};
}

}  // namespace apps
