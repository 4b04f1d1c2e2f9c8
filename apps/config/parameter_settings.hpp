#pragma once
#include <string>
#include <utility>
#include <vector>

namespace apps {

/// "p=v" as name and number. Throws std::invalid_argument.
[[nodiscard]] std::vector<std::pair<std::string, double>> parse_settings(const std::vector<std::string>& settings);

/// `value` where it is from `least` to `most`. Throws dsp::Fault (usage) called `fault` that says what `option` wants.
double require_within(double value, double least, double most, const char* fault, const char* option);
/// Noise of more than a thousand times a signal leaves nothing of it in a million rows, whose means are a thousand
/// times better than each.
inline constexpr double most_noise = 1e3;

}  // namespace apps
