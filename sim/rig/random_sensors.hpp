#pragma once
#include <array>
#include <cstdint>

#include "sim/rig/qzs_sensors.hpp"

namespace sim {

/// Draws what a user does not know of the rig's sensors, the same on every machine: gains (standard deviation 0.5 % of
/// lasers, 1.5 % of accelerometers), offsets (1 mm, 0.2 mV), a laser's slow drift (a sine of 0.04 mm standard
/// deviation, period uniform in 700 to 2500 s) and the accelerometers' first high-pass cut-off (uniform in 0.3 to
/// 0.6 Hz). Lags and further cut-offs stay.
void draw_sensors(std::array<RigSensor, num_raw_channels>& sensors, std::uint64_t seed);

}  // namespace sim
