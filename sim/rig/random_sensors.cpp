#include "sim/rig/random_sensors.hpp"

#include <algorithm>
#include <cmath>

#include "dsp/values/constants.hpp"
#include "sim/noise.hpp"

namespace sim {
namespace {

constexpr std::uint64_t first_id = 100;  // of the channels' draws; sensor noise has the ids below

double uniform(const Noise& draws, std::uint64_t i, double from, double to) {
  // The normal distribution's own probability of a normal draw is uniform.
  return from + (to - from) * 0.5 * std::erfc(-draws.normal(i) / std::sqrt(2.0));
}

}  // namespace

void draw_sensors(std::array<RigSensor, num_raw_channels>& sensors, std::uint64_t seed) {
  for (std::size_t c = 0; c < sensors.size(); ++c) {
    RigSensor& sensor = sensors[c];
    const Noise draws(seed, first_id + c);
    const bool laser = sensor.unit == "m";
    sensor.gain = 1.0 + (laser ? 0.005 : 0.015) * draws.normal(0);
    sensor.offset = (laser ? 1e-3 : 0.2e-3 / sensor.volts_per_unit) * draws.normal(1);
    if (laser)
      sensor.drift = {.sine_m = 0.04e-3 * draws.normal(2),
                      .period_s = uniform(draws, 3, 700.0, 2500.0),
                      .phase = uniform(draws, 4, 0.0, dsp::two_pi)};
    if (!sensor.highpass_hz.empty()) sensor.highpass_hz.front() = uniform(draws, 5, 0.3, 0.6);
  }
}

}  // namespace sim
