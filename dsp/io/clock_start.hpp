#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace dsp {

/// What a clock said at a first sample.
struct ClockStart {
  double s = 0.0;  ///< since midnight where the clock is one of times of day, else since its own zero
  std::optional<std::int64_t> day{};  ///< that midnight's, since 1970-01-01; nothing where no date is known
  /// How much later `other` began; by days only where both are known.
  [[nodiscard]] double until(const ClockStart& other) const;
};

/// "2026-11-20 10:00:00.25"; seconds alone, "36000.25 s", without a date.
[[nodiscard]] std::string to_string(const ClockStart& start);

}  // namespace dsp
