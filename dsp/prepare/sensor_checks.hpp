#pragma once
#include <string>
#include <vector>

#include "dsp/prepare/prepared.hpp"
#include "dsp/sensors/sensor_problems.hpp"

namespace dsp {

struct ChannelSpec;

/// Lines for a sidecar's [[channel]] that would have kept the problem away, given what it says now (nullptr: it says
/// none of it): `sensitivity = "102 mV/g"`. A lag adds to the delay that is there.
[[nodiscard]] std::string remedy(const SensorProblem& problem, const ChannelSpec* channel);

/// Whether preparation took it away: of a pair that is equalised everything but opposite signs and scales that are off
/// by more than any sensor's tolerance.
[[nodiscard]] bool is_corrected(const Prepared& prepared, const SensorRelation& relation, const SensorProblem& problem);

/// Rows of quality.json, one line each, for what the sensors of a recording say of one another: "sensor.polarity",
/// "sensor.unit", "sensor.gain", "sensor.lag", "sensor.corner", each with what to change; a note where it was
/// corrected, a warning where it was not or is too much for a sensor's tolerance; and "sensor.relation" for each pair,
/// a warning where none could be found. `sidecar`: its file name, for messages.
[[nodiscard]] std::vector<Check> sensor_checks(const Prepared& prepared, const std::vector<ChannelSpec>& channels,
                                               const std::string& sidecar);

}  // namespace dsp
