#pragma once
#include <string>
#include <utility>
#include <vector>

#include "dsp/motion.hpp"

namespace support {

/// A motion of these signals, units SI by name, nothing excluded.
inline dsp::Motion motion_of(double sample_rate_hz,
                             const std::vector<std::pair<std::string, Eigen::VectorXd>>& signals) {
  dsp::Motion motion;
  motion.sample_rate_hz = sample_rate_hz;
  for (const auto& [name, values] : signals) {
    const bool acceleration = name == "a" || name == "ddr" || name == "ddy";
    const std::string unit = name == "t"                                   ? "s"
                             : acceleration                                ? "m/s^2"
                             : name == "v" || name == "dr" || name == "dy" ? "m/s"
                                                                           : "m";
    motion.signals.push_back({name, name == "f" || name == "z" ? "N" : unit, values});
  }
  motion.excluded.assign(static_cast<std::size_t>(motion.num_samples()), 0);
  return motion;
}

}  // namespace support
