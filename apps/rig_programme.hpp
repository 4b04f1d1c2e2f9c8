#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/rig/base_motion.hpp"

namespace apps {

/// Name and number, as --set gave them.
using Settings = std::vector<std::pair<std::string, double>>;

/// The test of the rig called "down", "up" or "decay". Takes from `settings` those that are its own: down and up:
/// amplitude_mm, dwell_s, and from_hz, to_hz, step_hz for an even ladder of frequencies; decay: amplitude_mm, dwell_s,
/// releases. Throws std::invalid_argument.
[[nodiscard]] sim::Programme rig_programme(std::string_view name, Settings& settings);

/// The settings it knows, for messages.
[[nodiscard]] std::string_view programme_settings(std::string_view name);

}  // namespace apps
