#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/rig/base_motion.hpp"

namespace sim {

/// The test of the rig called "down", "up" or "decay". Takes from `settings`, names and values, those that are its own:
/// down and up: amplitude_mm, dwell_s, and from_hz, to_hz, step_hz for an even ladder of frequencies; decay:
/// amplitude_mm, dwell_s, releases. Throws std::invalid_argument.
[[nodiscard]] Programme rig_programme(std::string_view name, std::vector<std::pair<std::string, double>>& settings);

/// The settings it knows, for messages.
[[nodiscard]] std::string_view programme_settings(std::string_view name);

}  // namespace sim
