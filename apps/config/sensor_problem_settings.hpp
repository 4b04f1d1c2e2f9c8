#pragma once
#include <string>
#include <vector>

#include "sim/rig/qzs_sensors.hpp"

namespace apps {

/// Takes the sensor problems out of `--set` settings and leaves the rest: rail=CHANNEL:FROM:TO (at the upper rail),
/// hold=CHANNEL:FROM:TO (stuck at its value), clip=CHANNEL:FROM:TO:VOLTS (limited to +-VOLTS). CHANNEL is a name or its
/// 1-based index, times are seconds. Throws std::invalid_argument.
[[nodiscard]] std::vector<sim::SensorProblem> take_sensor_problems(std::vector<std::string>& settings);

}  // namespace apps
