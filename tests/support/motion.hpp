#pragma once
#include <string>
#include <utility>
#include <vector>

#include "dsp/sensors/motion.hpp"

namespace support {

/// A motion of these signals, units SI by name, nothing excluded.
inline dsp::Motion motion_of(double sample_rate_hz,
                             const std::vector<std::pair<std::string, Eigen::VectorXd>>& signals) {
  dsp::Motion motion;
  motion.sample_rate_hz = sample_rate_hz;
  for (const auto& [name, values] : signals) {
    const dsp::SignalInfo* known = dsp::find_signal(name);
    motion.signals.push_back({name, std::string(known != nullptr ? known->unit : "m"), values});
  }
  motion.excluded.assign(static_cast<std::size_t>(motion.num_samples()), 0);
  return motion;
}

}  // namespace support
