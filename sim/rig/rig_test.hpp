#pragma once
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/rig/qzs_rig.hpp"
#include "sim/rig/qzs_sensors.hpp"

namespace sim {

struct RigTestOptions {
  std::string twin = "T0", programme = "down";                ///< as qzs_twin and rig_programme name them
  std::vector<std::pair<std::string, double>> settings = {};  ///< of the programme and of the twin, by name
  double from_s = 0.0;                                        ///< what is recorded begins this far into the test
  std::optional<double> duration_s = {};  ///< of what is recorded; none: the programme's, beyond which it repeats
  double rate_hz = raw_rate_hz;           ///< of the recording: whole, at most raw_rate_hz
  RawOptions raw = {};                    ///< of faults the times count from from_s on
};

/// A test of the rig and the part of it that is recorded, checked.
struct RigTest {
  std::shared_ptr<const QzsRig> rig;
  std::string twin, programme;
  double from_s = 0.0, duration_s = 0.0, rate_hz = raw_rate_hz;
  RawOptions raw;
};

/// Throws std::invalid_argument for names that are not known and numbers that no test has.
[[nodiscard]] RigTest rig_test(const RigTestOptions& options);

}  // namespace sim
