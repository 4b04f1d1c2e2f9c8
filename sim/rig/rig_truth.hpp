#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/rig/qzs_regimes.hpp"
#include "sim/rig/rig_test.hpp"

namespace sim {

inline constexpr int truth_rate_hz = 256;  ///< that regimes are judged at, the preparation's intermediate rate

/// What a hand at the payload did; times from the recording's beginning on.
struct HandTruth {
  double from_s = 0.0, to_s = 0.0;
  std::string why;
  std::optional<double> released_at_m = {};  ///< x where it let go of what it gripped; NaN: after the recording's end
};

/// What is true of a test within its recording; times from the recording's beginning on.
struct RigTruth {
  std::vector<HandTruth> hands;
  std::vector<RegimeInterval> regimes;  ///< in order without gaps
  std::int64_t num_events = 0;          ///< switches of the friction
};

struct RigTruthOptions {
  std::function<void(const QzsState&)> take = {};  ///< each exact state at truth_rate_hz; its t_s is the test's
  std::function<void(double)> progress = {};       ///< called with the fraction of the motion made; may throw to stop
};

/// By integrating the test from its start to the end of the recording. Throws Diverged where the payload runs away
/// within the recording.
[[nodiscard]] RigTruth rig_truth(const RigTest& test, const RigTruthOptions& options = {});

/// The memory that rig_truth takes, at most.
[[nodiscard]] double rig_truth_bytes(const RigTest& test);

}  // namespace sim
