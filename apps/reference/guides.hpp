#pragma once
#include <array>
#include <string_view>

namespace apps {

// Texts of docs/ that the build puts into the program (apps/page/embed.cmake).

[[nodiscard]] std::string_view tutorial_text();
[[nodiscard]] std::string_view method_text();
[[nodiscard]] std::string_view validation_text();

/// A document that `ardent help NAME` shows as it is, in Markdown.
struct Guide {
  std::string_view name, summary;
  std::string_view (*text)();
};
inline constexpr std::array guides{
    Guide{"tutorial", "A simulated record from file to equation, step by step", &tutorial_text},
    Guide{"method", "How it works, and where it corrects the paper", &method_text},
    Guide{"validation", "How often it is right, and where it is not", &validation_text}};

}  // namespace apps
